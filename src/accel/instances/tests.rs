use super::*;
use crate::math::Vec3;

/// A tree over `n` unit boxes along x asks every one of them once, whatever the boxes' places.
#[test]
fn every_box_is_found_once() {
    for n in [1usize, 2, 3, 17, 200] {
        for step in [0.0f32, 2.0, 1e6] {
            let boxed = |i: usize| {
                let x = i as f32 * step;
                Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) }
            };
            let tree = Tree::new(&(0..n).map(boxed).collect::<Vec<_>>());
            let mut rays = Rays::default();
            rays.set(3, Vec3::new(-1.0, 0.5, 0.5), Vec3::X, 0.0, f32::INFINITY);
            rays.set(7, Vec3::new(-1.0, 1.5, 0.5), Vec3::X, 0.0, f32::INFINITY);
            let mut seen = vec![0; n];
            let checked = rays.check(1 << 3 | 1 << 7);
            tree.visit(&mut Lanes::new(checked), checked.active(), |_, i, inside| {
                assert_eq!(inside, 1 << 3);
                seen[i] += 1;
                0
            });
            assert!(seen.iter().all(|count| *count == 1), "{n} boxes {step} apart: {seen:?}");
        }
    }
}

/// The nearest is asked first, and what lies behind the hit then is not asked at all.
#[test]
fn shortened_rays_leave_out_what_is_behind() {
    let boxed = |i: usize| {
        let x = 4.0 * i as f32;
        Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) }
    };
    let tree = Tree::new(&(0..64).map(boxed).collect::<Vec<_>>());
    let mut rays = Rays::default();
    rays.set(0, Vec3::new(-1.0, 0.5, 0.5), Vec3::X, 0.0, f32::INFINITY);
    let checked = rays.check(1);
    let mut seen = Vec::new();
    tree.visit(&mut Lanes::new(checked), 1, |lanes, i, _| {
        seen.push(i);
        lanes.far[0] = 1.5 + 4.0 * i as f32;
        0
    });
    assert_eq!(seen, [0]);
    let mut seen = Vec::new();
    tree.visit(&mut Lanes::new(checked), 1, |_, i, _| {
        seen.push(i);
        1
    });
    assert_eq!(seen, [0], "a lane that is done goes no further");
}
