use super::super::auto::Up;
use super::*;
use crate::camera::Camera;

/// A bent strip of triangles, away from the origin, with a vertex that no triangle uses.
fn strip(scale: f64, center: DVec3) -> Vec<Arc<Mesh>> {
    let mut positions: Vec<[f32; 3]> = (0..60)
        .map(|i| {
            let t = f64::from(i) / 10.0;
            let p = DVec3::new(libm::sin(2.0 * t), 0.3 * t, libm::cos(3.0 * t) * 0.7) * scale + center;
            p.as_vec3().to_array()
        })
        .collect();
    let indices = (0..58).map(|i| [i, i + 1, i + 2]).collect();
    positions.push([1e6; 3]);
    vec![Arc::new(Mesh::new(positions, indices))]
}

/// Window coordinates of a point, 0 to 1 from the top left, by the camera's own rays: the inverse of
/// [`Camera::ray`] along the viewing axis.
fn project(spec: &CameraSpec, p: DVec3) -> [f64; 2] {
    let forward = (spec.look_at - spec.position).normalize();
    let right = forward.cross(spec.up).normalize();
    let up = right.cross(forward);
    let d = p - spec.position;
    let depth = d.dot(forward);
    assert!(depth > 0.0, "behind the camera");
    let scale = if spec.projection == Projection::Perspective { spec.window.distance / depth } else { 1.0 };
    let w = &spec.window;
    [(d.dot(right) * scale - w.left) / (w.right - w.left), (d.dot(up) * scale - w.top) / (w.bottom - w.top)]
}

fn check(spec: &CameraSpec, meshes: &[Arc<Mesh>], origin: DVec3, what: &str) {
    Camera::new(spec, origin).unwrap();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in &meshes[0].positions[..60] {
        let at = project(spec, DVec3::from(p.map(f64::from)) + origin);
        for i in 0..2 {
            low[i] = low[i].min(at[i]);
            high[i] = high[i].max(at[i]);
        }
    }
    for i in 0..2 {
        assert!(
            low[i] >= auto::MARGIN - 1e-6 && high[i] <= 1.0 - auto::MARGIN + 1e-6,
            "{what}: {low:?} {high:?}"
        );
    }
    // Tight: one of the two directions is filled from margin to margin.
    let filled = (0..2).any(|i| high[i] - low[i] > 1.0 - 2.0 * auto::MARGIN - 1e-6);
    assert!(filled, "{what}: {low:?} {high:?}");
}

#[test]
fn every_vertex_is_inside_the_margin_for_all_views_and_aspects() {
    let meshes = strip(1.0, DVec3::new(3.0, -2.0, 5.0));
    for projection in [Projection::Perspective, Projection::Orthographic] {
        for (view_name, _, view) in View::TABLE {
            for (up_name, _, up) in Up::TABLE {
                for size in [[1024, 768], [100, 1000], [4000, 100], [1, 1]] {
                    let plan = CameraPlan { projection, up: Some(up.vector()), ..CameraPlan::default() };
                    let spec = plan.frame(*view, size, &meshes, DVec3::ZERO);
                    check(
                        &spec,
                        &meshes,
                        DVec3::ZERO,
                        &format!("{projection:?} {view_name} {up_name} {size:?}"),
                    );
                }
            }
        }
    }
}

#[test]
fn scale_origin_and_lens_do_not_matter() {
    for scale in [1e-6, 1.0, 1e6] {
        let meshes = strip(scale, DVec3::ZERO);
        for lens in [
            Lens::Fov(1.0),
            Lens::Fov(60.0),
            Lens::Plane(Window { left: -0.2, right: 1.0, top: 0.4, bottom: -0.9, distance: 2.0 }),
        ] {
            let plan = CameraPlan { lens, ..CameraPlan::default() };
            let origin = DVec3::new(1e4, -3e4, 1e4) * scale;
            let spec = plan.frame(View::default(), [300, 200], &meshes, origin);
            check(&spec, &meshes, origin, &format!("{scale} {lens:?}"));
        }
    }
}

#[test]
fn points_lines_and_nothing_still_give_a_camera() {
    let point = vec![Arc::new(Mesh::new(vec![[1.0, 2.0, 3.0]; 3], vec![[0, 1, 2]]))];
    let line = vec![Arc::new(Mesh::new(vec![[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]], vec![[0, 1, 2]]))];
    for meshes in [&point, &line, &Vec::new()] {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let plan = CameraPlan { projection, ..CameraPlan::default() };
            for (name, _, view) in View::TABLE {
                let spec = plan.frame(*view, [64, 48], meshes, DVec3::ZERO);
                Camera::new(&spec, DVec3::ZERO).unwrap_or_else(|e| panic!("{name}: {e}"));
                assert!(spec.focus_distance > 0.0);
            }
        }
    }
}

#[test]
fn a_position_alone_looks_at_the_middle() {
    let meshes = strip(1.0, DVec3::ZERO);
    let plan = CameraPlan { position: Some(DVec3::new(0.0, 10.0, 0.0)), ..CameraPlan::default() };
    let spec = plan.frame(View::default(), [64, 48], &meshes, DVec3::ZERO);
    Camera::new(&spec, DVec3::ZERO).unwrap();
    assert_eq!(spec.position, DVec3::new(0.0, 10.0, 0.0));
    let at = project(&spec, middle(&meshes).unwrap());
    assert!((at[0] - 0.5).abs() < 1e-9 && (at[1] - 0.5).abs() < 1e-9);
}
