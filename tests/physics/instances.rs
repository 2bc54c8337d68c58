//! One mesh in many places gives the picture of as many copies.

use drt::film::Data;

use crate::harness::{SKY, cube, on_every_backend, picture, stage, stage_bytes};

const VIEW: &str = "[camera]\nposition = [3, 4, 9]\nlook_at = [0, 0, 0]\n[film]\nsize = [48, 32]\naov = [\"ids\", \"normal\"]\n\
                    [render]\nspp = 64\nmax_depth = 4\n";

/// Copies and instances differ by rounding alone, under scales, mirrors, shears and rotations, with materials of their
/// own, far from the origin and near.
#[test]
fn instances_give_the_picture_of_copies() {
    let placed = |instance: bool, shift: f64| {
        let at = |x: f64, y: f64| format!("translate = [{}, {y}, 0]", x + shift);
        format!(
            "{}{SKY}[[mesh]]\nfile = \"cube.obj\"\nnormals = \"smooth\"\ncrease = 30\nmaterial = \"grey\"\ninstance = {instance}\n\
             instances = [{{ {} }}, {{ scale = [-1, 0.5, 1], rotate = {{ axis = [1, 1, 0], angle = 40 }}, {} }},\n\
             {{ scale = 0.3, {}, material = \"glass\" }}, {{ matrix = [1, 0.5, 0, {}, 0, 1, 0.2, -2, 0, 0, 1, 0, 0, 0, 0, 1] }}]\n\
             [materials.grey]\ntype = \"diffuse\"\nreflectance = 0.6\n\
             [materials.glass]\ntype = \"dielectric\"\nior = 1.5\n",
            VIEW.replace("position = [3", &format!("position = [{}", 3.0 + shift))
                .replace("look_at = [0", &format!("look_at = [{shift}")),
            at(0.0, 0.0),
            at(3.0, 0.0),
            at(-2.5, 1.0),
            shift - 3.0,
        )
    };
    on_every_backend(|backend| {
        for shift in [0.0, 1e6] {
            let of = |instance: bool| {
                let stage = stage(&placed(instance, shift), &[("cube.obj", cube())], backend, &[]);
                let places = stage.scene.instances.places.len();
                assert_eq!(places, if instance { 4 } else { 0 });
                assert_eq!(stage.scene.triangles(), if instance { 12 } else { 48 });
                let image = stage.render(|_| ()).0;
                let ids = image.channels.iter().find_map(|c| match &c.data {
                    Data::U32(ids) if c.name == "id.mesh" => Some(ids.clone()),
                    _ => None,
                });
                (
                    image.f32_channel("G").unwrap().to_vec(),
                    image.f32_channel("normal.X").unwrap().to_vec(),
                    ids,
                )
            };
            let ((a, na, ia), (b, nb, ib)) = (of(false), of(true));
            let renumbered = ia.iter().flatten().zip(ib.iter().flatten()).filter(|(a, b)| a != b).count();
            assert!(ia.is_some() && renumbered <= 3, "{renumbered} pixels show other meshes");
            let differ =
                |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 2e-3).count();
            let (pixels, normals) = (differ(&a, &b), differ(&na, &nb));
            assert!(pixels <= 15 && normals <= 8, "{pixels} pixels and {normals} normals of 1536 differ");
        }
    });
}

/// Reliefs, cut-outs and pictures are those of the mesh, wherever it stands.
#[test]
fn pictures_and_holes_go_with_the_instance() {
    let leaf = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let mut files = vec![("leaf.obj", leaf.as_bytes().to_vec())];
    let checks: Vec<[u8; 3]> =
        (0..16).map(|i| if (i + i / 4) % 2 == 0 { [200; 3] } else { [20; 3] }).collect();
    files.push(("checks.png", picture(4, &checks)));
    let toml = |instance: bool| {
        format!(
            "{VIEW}{SKY}[[mesh]]\nfile = \"leaf.obj\"\nmaterial = \"leaf\"\ninstance = {instance}\n\
             instances = [{{ scale = 2 }}, {{ rotate = {{ axis = [0, 1, 0], angle = 50 }}, translate = [0, 0, -2] }}]\n\
             [materials.leaf]\ntype = \"diffuse\"\nreflectance = {{ texture = \"checks.png\" }}\n\
             opacity = {{ texture = \"checks.png\" }}\nbump = {{ texture = \"checks.png\", height = 0.1 }}\n"
        )
    };
    on_every_backend(|backend| {
        let of = |instance| {
            let (image, _) = stage_bytes(&toml(instance), &files, backend, &[]).render(|_| ());
            image.f32_channel("G").unwrap().to_vec()
        };
        let (a, b) = (of(false), of(true));
        let differing = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 2e-3).count();
        assert!(differing <= 15, "{differing} of 1536 pixels differ");
        assert!(a.iter().any(|v| *v < 0.8) && a.iter().any(|v| *v > 0.95), "there is something to see");
    });
}
