use super::*;

fn split(points: &[DVec3]) -> Vec<[u32; 3]> {
    let mut t = Triangulator { points: points.to_vec(), ..Default::default() };
    t.split().unwrap().to_vec()
}
