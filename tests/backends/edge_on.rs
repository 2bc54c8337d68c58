//! Rays along walls: a triangle seen edge-on hides nothing and is met nowhere but where it is.

use super::*;
use drt::accel::judge::Answer;
use drt::diff::aimed;
use drt::diff::court::Court;
use drt::diff::{Class, Contestant};

/// The Cornell box.
fn room() -> Mesh {
    const CORNERS: [[f32; 3]; 28] = [
        [552.8, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 559.2],
        [549.6, 0.0, 559.2],
        [343.0, 548.7, 227.0],
        [343.0, 548.7, 332.0],
        [213.0, 548.7, 332.0],
        [213.0, 548.7, 227.0],
        [556.0, 548.8, 0.0],
        [556.0, 548.8, 559.2],
        [0.0, 548.8, 559.2],
        [0.0, 548.8, 0.0],
        [130.0, 165.0, 65.0],
        [82.0, 165.0, 225.0],
        [240.0, 165.0, 272.0],
        [290.0, 165.0, 114.0],
        [290.0, 0.0, 114.0],
        [240.0, 0.0, 272.0],
        [130.0, 0.0, 65.0],
        [82.0, 0.0, 225.0],
        [423.0, 330.0, 247.0],
        [265.0, 330.0, 296.0],
        [314.0, 330.0, 456.0],
        [472.0, 330.0, 406.0],
        [423.0, 0.0, 247.0],
        [472.0, 0.0, 406.0],
        [314.0, 0.0, 456.0],
        [265.0, 0.0, 296.0],
    ];
    #[rustfmt::skip]
    const QUADS: [[u32; 4]; 16] = [
        [1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12], [4, 3, 11, 10], [3, 2, 12, 11], [1, 4, 10, 9],
        [13, 14, 15, 16], [17, 16, 15, 18], [19, 13, 16, 17], [20, 14, 13, 19], [18, 15, 14, 20], [21, 22, 23, 24],
        [25, 21, 24, 26], [26, 24, 23, 27], [27, 23, 22, 28], [28, 22, 21, 25],
    ];
    let triangles = |q: [u32; 4]| [[q[0] - 1, q[1] - 1, q[2] - 1], [q[0] - 1, q[2] - 1, q[3] - 1]];
    Mesh::new(CORNERS.to_vec(), QUADS.into_iter().flat_map(triangles).collect())
}

/// Found by `drt diff-backends` on this room, with some backend each.
const RAYS: [([f32; 3], [f32; 3], f32); 7] = [
    // Seen edge-on, a wall of a box is met at a distance that hides the top: Embree, sse2 and avx512.
    ([393.51205, 396.78488, 317.66498], [-47.29803, -71.41438, -14.069668], f32::INFINITY),
    ([252.4203, 607.63983, 254.92343], [0.00105973, -0.023388738, 0.0034603432], f32::INFINITY),
    ([503.96124, 655.46985, 509.71097], [-0.09315808, -0.9486534, -0.30228844], f32::INFINITY),
    // A wall that the ray passes in its plane, far away, is hit.
    ([436.53265, 448.8912, 158.87563], [-0.45420408, -0.87997144, -0.13910002], 454.5538),
    // Where a wall ends on the floor, the floor is hit; the hit is the ray's, not that of the ray that was moved to
    // find it out.
    ([846.31616, -193.02313, 287.22885], [-0.9249511, 0.24924323, -0.28695545], f32::INFINITY),
    ([1037.7396, -522.12366, 337.21533], [-0.83895266, 0.482558, -0.25158733], f32::INFINITY),
    ([219.03421, -10.552643, -426.66824], [0.2897457, 0.014990664, 0.95698625], 703.94763),
];

#[test]
fn rays_along_walls_hit_what_they_meet() {
    let rays = RAYS.map(|(o, d, tmax)| (Vec3::from(o), Vec3::from(d), 0.0, tmax));
    nobody_is_wrong(room(), &rays);
}

/// A ray past the tip of a triangle seen at a grazing angle: two others are met behind, and the nearer one does not come
/// near the tip, so that it was not among the triangles around.
#[test]
fn nothing_behind_the_triangles_around_is_taken() {
    let corners = [
        [0.9394288, -0.8958837, 0.22119898],
        [0.98472273, -0.95481753, 0.2214201],
        [0.9793106, -0.941986, 0.21550044],
        [0.78739893, -0.5491085, 0.29773435],
        [0.7916923, -0.9211097, 0.13702624],
        [1.1810752, -1.0584158, -0.20391098],
        [0.8398534, -0.8470085, 0.23991197],
        [0.9814334, -0.85546315, 0.1358832],
        [0.9002525, -0.8428718, 0.22196026],
    ];
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    let o = Vec3::new(1.138768, -3.2547622, 2.3762882);
    nobody_is_wrong(mesh, &[(o, Vec3::new(-50.291595, 595.1253, -543.71094), 0.0, f32::INFINITY)]);
}

/// A ray past the tips of tiny triangles in a row, all seen edge-on: next to the one that Embree meets first lies another,
/// and so on, so that a step aside finds nothing better. What they hide is clearly met.
#[test]
fn a_row_of_tiny_triangles_seen_edge_on_hides_nothing() {
    let corners = [
        [-0.398769, 0.581086, 0.704199],
        [-0.401392, 0.580482, 0.704062],
        [-0.398785, 0.57813, 0.704227],
        [0.014775, 0.030854, -0.013384],
        [0.014693, 0.03086, -0.013429],
        [0.014684, 0.03086, -0.013434],
        [0.014675, 0.030861, -0.013439],
        [0.014666, 0.030861, -0.013444],
        [0.014657, 0.030862, -0.013449],
        [0.014648, 0.030862, -0.013455],
        [0.014639, 0.030862, -0.01346],
        [0.016059, 0.029054, -0.01579],
        [0.016056, 0.029054, -0.015791],
        [0.016037, 0.029052, -0.015802],
        [0.016035, 0.029052, -0.015803],
        [0.016032, 0.029051, -0.015804],
        [0.01603, 0.029051, -0.015806],
        [0.016028, 0.029051, -0.015807],
        [0.016025, 0.029051, -0.015808],
        [0.016023, 0.02905, -0.01581],
    ];
    let all = vec![
        [0, 1, 2],
        [3, 12, 11],
        [4, 14, 13],
        [4, 5, 14],
        [5, 15, 14],
        [5, 6, 15],
        [6, 16, 15],
        [6, 7, 16],
        [7, 8, 17],
        [8, 18, 17],
        [8, 9, 18],
        [9, 19, 18],
        [9, 10, 19],
    ];
    let pair = vec![all[0], all[4], all[6]];
    let o = Vec3::new(0.42000392, -0.50785553, -0.7167717);
    let d = Vec3::new(-0.41604647, 0.55294895, 0.7219091);
    for triangles in [pair, all] {
        nobody_is_wrong(Mesh::new(corners.to_vec(), triangles), &[(o, d, 0.0, f32::INFINITY)]);
    }
}

/// Packets and single rays, every instruction set and quality, against f64.
fn nobody_is_wrong(mesh: Mesh, rays: &[Ray]) {
    let meshes = one(mesh);
    let court = Court::new(&meshes);
    let packets = aimed::chunks(rays.iter().copied());
    let singles = rays.iter().flat_map(|ray| aimed::chunks(std::iter::once(*ray)));
    let chunks: Vec<_> = packets.into_iter().chain(singles).collect();
    for contestant in Contestant::all().iter().filter(|contestant| contestant.counts) {
        let built = contestant.intersector(&meshes, 1, &|_| true).expect("builds");
        for chunk in &chunks {
            let mut hits = Hits::default();
            built.closest(chunk.rays.check(chunk.mask), Coherence::Incoherent, &mut hits);
            for lane in (0..LANES).filter(|lane| chunk.mask >> lane & 1 == 1) {
                let answer = Answer::of(&hits, lane);
                let truth = court.truth(&drt::accel::brute::Ray64::of(&chunk.rays, lane));
                let finding = court.closest(&chunk.rays, lane, [answer, truth]);
                let wrong = finding.is_some_and(|f| f.class == Class::Real);
                assert!(!wrong, "{}: {answer:?}, f64: {truth:?}, {finding:?}", contestant.name());
            }
        }
    }
}
