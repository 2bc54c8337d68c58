//! Where a closed body turns away: front and back triangle meet at an edge, and a ray must be given the right one.

use super::*;
use drt::math::DVec3;

/// The edges where a closed body turns away from `o`: one face is seen from outside, the other is not.
fn silhouette(mesh: &Mesh, outwards: f64, o: Vec3) -> Vec<[Vec3; 2]> {
    let mut edges: Vec<([u32; 2], usize)> = Vec::new();
    for (i, t) in mesh.indices.iter().enumerate() {
        edges.extend((0..3).map(|k| (t[k], t[(k + 1) % 3])).map(|(a, b)| ([a.min(b), a.max(b)], i)));
    }
    edges.sort_unstable();
    let faces = |i: usize| (o - mesh.triangle(i)[0]).as_dvec3().dot(normal(mesh, i)) * outwards > 0.0;
    let turns = |p: &&[([u32; 2], usize)]| p[0].0 == p[1].0 && faces(p[0].1) != faces(p[1].1);
    edges.windows(2).filter(turns).map(|p| p[0].0.map(|i| Vec3::from(mesh.positions[i as usize]))).collect()
}

/// Normal of a triangle, as long as twice its area.
fn normal(mesh: &Mesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.triangle(triangle).map(|p| p.as_dvec3());
    (b - a).cross(c - a)
}

/// +1 where a closed mesh is wound so that normals point outwards, else −1.
fn outwards(mesh: &Mesh) -> f64 {
    let volume = |i| mesh.triangle(i)[0].as_dvec3().dot(normal(mesh, i));
    (0..mesh.indices.len()).map(volume).sum::<f64>().signum()
}

/// How many of `rays` meet a triangle from behind, `outwards` being its front. Seen edge-on, within rounding,
/// neither side is wrong.
fn from_behind(mesh: &Mesh, outwards: f64, backend: &dyn Intersector, rays: &[Ray]) -> usize {
    let chunks = chunks(rays);
    let behind = |c: &Rays, h: &Hits, lane: usize| {
        h.mesh[lane] != MISS && {
            let n = normal(mesh, h.triangle[lane] as usize) * outwards;
            n.normalize_or_zero().dot(c.d(lane).as_dvec3().normalize_or_zero()) > 1e-7
        }
    };
    let count = |(c, h): (&Rays, &Hits)| (0..LANES).filter(|&lane| behind(c, h, lane)).count();
    chunks.iter().zip(&trace(backend, &chunks)).map(count).sum()
}

/// Rays from `eye` at the silhouette's edges, at its corners, and at random.
fn at_the_silhouette(mesh: &Mesh, outwards: f64, eye: Vec3, random: &mut Random) -> [Vec<Ray>; 3] {
    let mut rays = [vec![], vec![], vec![]];
    for [a, b] in silhouette(mesh, outwards, eye) {
        rays[0].extend((0..40).map(|_| towards(eye, a.lerp(b, 0.05 + 0.9 * random.unit()))));
        rays[1].push(towards(eye, a));
    }
    let (center, size) = (mesh.bounds().center(), mesh.bounds().extent().max_element());
    rays[2].extend((0..10_000).map(|_| towards(eye, center + random.ball() * size)));
    rays
}

/// How many of the rays of each kind may meet the wrong side. The hierarchy is left with corners at which it sees
/// triangles edge-on. Embree loses rays through corners, around which it sees them pass outside of every
/// triangle, and through triangles seen edge-on; nothing near the hit behind tells.
fn forgiven(backend: Backend, [edges, corners, _]: [usize; 3]) -> [usize; 3] {
    if backend == Backend::Bvh {
        [edges / 1_000_000, corners / 2000, 0]
    } else {
        [edges / 20_000, corners / 50, 0]
    }
}

/// What became of the rays of each kind.
#[derive(Default)]
struct Count {
    all: [usize; 3],
    wrong: [usize; 3],
    missed: [usize; 3],
}

/// Shoots at the silhouette from every eye that `eye` gives, and counts the rays that meet the wrong side, `side` being
/// the right one's sign. One eye at a time: their rays together would fill the memory.
fn shoot(what: &str, mesh: &Mesh, side: f64, mut eye: impl FnMut(usize, &mut Random) -> Vec3) -> Vec<Count> {
    let built: Vec<_> = Backend::ALL.iter().map(|b| build(*b, &one(mesh.clone()))).collect();
    let mut counts: Vec<Count> = built.iter().map(|_| Count::default()).collect();
    let mut random = Random(11);
    let outwards = outwards(mesh);
    // Some twenty million rays a body are enough.
    for i in 0..12 * effort().min(8) {
        let eye = eye(i, &mut random);
        let rays = at_the_silhouette(mesh, outwards, eye, &mut random);
        for (built, count) in built.iter().zip(&mut counts) {
            for (k, rays) in rays.iter().enumerate() {
                count.all[k] += rays.len();
                count.wrong[k] += from_behind(mesh, side, &**built, rays);
                count.missed[k] += missed(&trace(&**built, &chunks(rays)), rays.len());
            }
        }
    }
    for (backend, Count { all, wrong, .. }) in Backend::ALL.iter().zip(&counts) {
        assert!(all[0] > 20_000, "{what}: {} rays", all[0]);
        let forgiven = forgiven(*backend, *all);
        let fine = (0..3).all(|k| wrong[k] <= forgiven[k]);
        assert!(fine, "{what}: {} meets the wrong side with {wrong:?} of {all:?} rays", backend.name());
    }
    counts
}

/// Rays from outside a closed body, aimed at the edges where it turns away, do not meet its inside: a path would go
/// on within it. (Not settled, Embree gives the back triangle for one in nine, the hierarchy for one in 150.)
#[test]
fn rays_from_outside_meet_the_outside() {
    let bodies = [
        ("torus", torus(60)),
        ("rough torus", rough(&torus(200), 0.003)),
        ("sphere", uv_sphere(80)),
        ("far sphere", mapped(&uv_sphere(80), |p| p + 100.0)),
        ("flat sphere", mapped(&uv_sphere(80), |p| p * Vec3::new(1.0, 0.01, 1.0))),
    ];
    for (what, mesh) in bodies {
        let bounds = mesh.bounds();
        shoot(what, &mesh, outwards(&mesh), |_, random| {
            let distance = bounds.extent().max_element() * (1.5 + random.unit());
            bounds.center() + random.cube().normalize_or(Vec3::X) * distance
        });
    }
}

/// The mirror image: rays from inside meet the inside, and do not leave through an edge.
#[test]
fn rays_from_inside_meet_the_inside() {
    for (what, mesh) in [("torus", torus(60)), ("rough torus", rough(&torus(200), 0.003))] {
        let counts = shoot(what, &mesh, -outwards(&mesh), |i, random| {
            Vec3::new((i as f32).cos(), 0.0, (i as f32).sin()) + random.ball() * 0.2
        });
        for (backend, Count { all, missed, .. }) in Backend::ALL.iter().zip(counts) {
            // Embree itself lets three in a million rays through that are aimed at edges; none at random.
            let forgiven = if *backend == Backend::Bvh { 0 } else { all[0] / 200_000 };
            let fine = missed[0] <= forgiven && missed[2] == 0;
            assert!(fine, "{what}: {} leaks {missed:?} of {all:?} rays", backend.name());
        }
    }
}
