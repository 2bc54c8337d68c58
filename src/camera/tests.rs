use super::*;
use crate::shape::Pose;

fn spec(projection: Projection, window: Window) -> CameraSpec {
    CameraSpec {
        projection,
        position: DVec3::new(0.0, 1.0, 5.0),
        look_at: DVec3::new(0.0, 1.0, 0.0),
        up: DVec3::Y,
        window,
        aperture: Aperture::default(),
        focus_distance: 5.0,
        shutter: [0.0; 2],
        motion: None,
        fps: 24.0,
    }
}

#[test]
fn the_top_left_corner_is_up_and_to_the_left() {
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let window = CameraSpec::fov_window(90.0, [200, 100]);
        let camera = Camera::new(&spec(projection, window), DVec3::ZERO).unwrap();
        let ray = camera.ray(0.0, 0.0, [0.5; 2], 0.0);
        let at = ray.o + ray.d;
        assert!(at.x < 0.0 && at.y > 1.0 && at.z < 5.0, "{projection:?}: {at}");
    }
}

#[test]
fn the_vertical_field_of_view_is_between_the_borders() {
    let window = CameraSpec::fov_window(40.0, [300, 200]);
    let camera = Camera::new(&spec(Projection::Perspective, window), DVec3::ZERO).unwrap();
    let (top, bottom) = (camera.ray(0.5, 0.0, [0.5; 2], 0.0).d, camera.ray(0.5, 1.0, [0.5; 2], 0.0).d);
    assert!((top.dot(bottom).acos().to_degrees() - 40.0).abs() < 1e-3);
}

#[test]
fn lens_rays_meet_in_the_plane_of_focus() {
    let window = CameraSpec::fov_window(40.0, [300, 200]);
    let mut spec = spec(Projection::Perspective, window);
    (spec.aperture, spec.focus_distance) = (Aperture::disk(0.2), 3.0);
    let camera = Camera::new(&spec, DVec3::new(0.0, 1.0, 0.0)).unwrap();
    let meet = |lens| {
        let ray = camera.ray(0.3, 0.7, lens, 0.0);
        ray.o + ray.d * ((2.0 - ray.o.z) / ray.d.z)
    };
    assert!((meet([0.1, 0.2]) - meet([0.9, 0.6])).length() < 1e-5);
    assert!((camera.ray(0.3, 0.7, [0.0, 0.5], 0.0).o - camera.eye).length() > 0.19);
}

/// The same places as an environment map's, for a camera that looks along +z.
#[test]
fn panoramas_are_environment_maps() {
    let window = CameraSpec::fov_window(40.0, [300, 200]);
    let mut spec = spec(Projection::Panorama, window);
    spec.look_at = spec.position + DVec3::Z;
    let camera = Camera::new(&spec, DVec3::ZERO).unwrap();
    for i in 0..1000 {
        let (x, y) = ((i as f32 + 0.5) / 1000.0, (i as f32 * 0.618_034).fract());
        let d = camera.ray(x, y, [0.5; 2], 0.0).d;
        let u = libm::atan2f(d.x, -d.z) / std::f32::consts::TAU;
        let sin = (std::f32::consts::PI * y).sin();
        assert!(((u - x).rem_euclid(1.0) * sin).min((x - u).rem_euclid(1.0) * sin) < 1e-6, "{x} {u}");
        assert!((libm::acosf(d.y) / std::f32::consts::PI - y).abs() < 1e-3, "{y}");
    }
    assert!(
        (camera.ray(0.75, 0.5, [0.5; 2], 0.0).d - camera.right).length() < 1e-6,
        "the right is on the right"
    );
}

#[test]
fn impossible_cameras_are_refused() {
    let window = CameraSpec::fov_window(40.0, [300, 200]);
    let good = spec(Projection::Perspective, window);
    let refused = |spec: &CameraSpec| Camera::new(spec, DVec3::ZERO).is_err();
    assert!(refused(&CameraSpec { look_at: good.position, ..good.clone() }));
    assert!(refused(&CameraSpec { up: DVec3::Z, ..good.clone() }));
    assert!(refused(&CameraSpec { position: DVec3::NAN, ..good.clone() }));
    assert!(refused(&CameraSpec { window: Window { right: window.left, ..window }, ..good.clone() }));
    assert!(!refused(&good));
}

/// A camera that goes one way and turns: rays start where it is, and the point that it turns to stays in the middle.
#[test]
fn a_moving_camera_sees_from_where_it_is() {
    let pose =
        |x: f64, degrees: f64| Pose::new(DVec3::ONE, Some((DVec3::Y, degrees)), DVec3::new(x, 0.0, 0.0));
    let motion = Motion::new(&[(2.0, pose(0.0, 0.0)), (4.0, pose(3.0, 90.0))]).unwrap();
    let window = CameraSpec::fov_window(40.0, [1, 1]);
    let moving = CameraSpec {
        shutter: [2.0, 3.0],
        motion: Some(Arc::new(motion)),
        ..spec(Projection::Perspective, window)
    };
    for origin in [DVec3::ZERO, DVec3::new(100.0, -7.0, 3.0)] {
        let camera = Camera::new(&moving, origin).unwrap();
        for (time, x, degrees) in [(0.0, 0.0, 0.0), (1.0, 1.5, 45.0)] {
            let ray = camera.ray(0.5, 0.5, [0.5; 2], time);
            let turned = rotation(DVec3::Y, degrees);
            let eye = turned * DVec3::new(0.0, 1.0, 5.0) + DVec3::X * x - origin;
            assert!((ray.o.as_dvec3() - eye).length() < 1e-4, "{} not {eye}", ray.o);
            assert!((ray.d.as_dvec3() - turned * -DVec3::Z).length() < 1e-6, "{}", ray.d);
        }
        assert!((camera.depth(camera.ray(0.5, 0.5, [0.5; 2], 0.0).d, 3.0) - 3.0).abs() < 1e-5);
    }
}

#[test]
fn an_orbit_keeps_the_distance_and_begins_where_the_camera_stands() {
    let camera = spec(Projection::Perspective, CameraSpec::fov_window(40.0, [1, 1]));
    assert_eq!(camera.orbited(0.0), camera);
    let quarter = camera.orbited(90.0);
    assert_eq!((quarter.position, quarter.look_at), (DVec3::new(5.0, 1.0, 0.0), camera.look_at));
}

/// Several rays at once are what each is by itself: every projection, with and without a lens, standing and moving.
#[test]
fn rays_are_those_of_their_lanes() {
    let number = |i: usize, k: usize| ((i * 7 + k * 3) as f32 * 0.618_034).fract();
    let numbers = |k: usize| -> [f32; 16] { std::array::from_fn(|i| number(i, k)) };
    for projection in [Projection::Perspective, Projection::Orthographic, Projection::Panorama] {
        for radius in [0.0, 0.2] {
            for moves in [false, true] {
                let mut spec = spec(projection, CameraSpec::fov_window(40.0, [300, 200]));
                spec.aperture = Aperture::disk(radius);
                if moves {
                    let pose = |time: f64| Pose::new(DVec3::ONE, None, DVec3::X * time);
                    spec.motion = Some(Motion::new(&[(0.0, pose(0.0)), (1.0, pose(1.0))]).unwrap().into());
                    spec.shutter = [0.0, 1.0];
                }
                let camera = Camera::new(&spec, DVec3::ZERO).unwrap();
                let (x, y, lens, time) = (numbers(0), numbers(1), [numbers(2), numbers(3)], numbers(4));
                let [o, d] = camera.rays([&x, &y], &lens, &time);
                for i in 0..16 {
                    let ray = camera.ray(x[i], y[i], [lens[0][i], lens[1][i]], time[i]);
                    assert_eq!((o.get(i), d.get(i)), (ray.o, ray.d), "{projection:?} {radius} {moves}");
                }
            }
        }
    }
}
