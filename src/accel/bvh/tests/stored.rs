//! Trees that were kept and taken up again.

use super::*;
use crate::accel::bvh::stored::{NODE, Stored, TRIANGLES};

fn take(nodes: &[[u32; NODE]], blocks: &[[u32; TRIANGLES]], meshes: &[Arc<Mesh>]) -> Option<Bvh> {
    let mut stored = Stored::new(nodes.len(), blocks.len()).unwrap();
    nodes.iter().for_each(|node| stored.node(*node));
    blocks.iter().for_each(|block| stored.block(*block));
    stored.finish(meshes, 1.0, None)
}

/// A bumpy sheet of 2·side² triangles.
fn sheet(side: u32) -> Vec<Arc<Mesh>> {
    let at = |i: u32| [(i % (side + 1)) as f32, (i * 7919 % 13) as f32 * 0.1, (i / (side + 1)) as f32];
    let corner = |i: u32| i + i / side;
    let quads = (0..side * side).map(corner);
    let triangles = quads.flat_map(|i| [[i, i + 1, i + side + 1], [i + 1, i + side + 2, i + side + 1]]);
    vec![Arc::new(Mesh::new((0..(side + 1) * (side + 1)).map(at).collect(), triangles.collect()))]
}

#[test]
fn a_tree_that_was_kept_is_the_same_tree() {
    for (side, quality) in
        [(40, Quality::Medium), (40, Quality::Low), (40, Quality::High), (2, Quality::Medium)]
    {
        let meshes = sheet(side);
        let built = Bvh::build(&meshes, &BuildOptions { quality, ..BuildOptions::default() }).unwrap();
        let (nodes, blocks): (Vec<_>, Vec<_>) = (built.nodes().collect(), built.blocks().collect());
        assert!(built.leaves_of_one() >= 1.0);
        let again = take(&nodes, &blocks, &meshes).unwrap();
        assert!(again.nodes().eq(nodes.iter().copied()) && again.blocks().eq(blocks.iter().copied()));
        assert_eq!(again.few.is_some(), built.few.is_some());
        assert_eq!(again.bytes(), built.bytes());
    }
    let nothing = Bvh::build(&[], &BuildOptions::default()).unwrap();
    assert!(nothing.nodes().len() == 0 && take(&[], &[], &[]).is_some());
}

/// Numbers that are no tree over these meshes, whatever their digest says.
#[test]
fn other_numbers_are_refused() {
    let meshes = sheet(40);
    let built = Bvh::build(&meshes, &BuildOptions::default()).unwrap();
    let (nodes, blocks): (Vec<_>, Vec<_>) = (built.nodes().collect(), built.blocks().collect());
    let first_child = nodes[0][48];
    assert!(first_child > 0 && first_child < nodes.len() as u32, "an inner node: {first_child}");
    type Nodes = Vec<[u32; NODE]>;
    type Blocks = Vec<[u32; TRIANGLES]>;
    type Change<'a> = (&'a str, &'a dyn Fn(&mut Nodes, &mut Blocks));
    let breaks: &[Change<'_>] = &[
        ("a node that is none", &|nodes, _| nodes[0][48] = nodes.len() as u32),
        ("a circle", &|nodes, _| nodes[first_child as usize][48] = first_child),
        ("a child of two", &|nodes, _| nodes[0][49] = first_child),
        ("a node of nobody", &|nodes, _| nodes.push(nodes[0])),
        ("no root", &|nodes, _| nodes.clear()),
        ("no triangles", &|_, blocks| blocks.clear()),
        ("a leaf beyond the end", &|_, blocks| blocks.truncate(blocks.len() - 1)),
        ("a plane that is none", &|nodes, _| nodes[0][0] = f32::NAN.to_bits()),
        ("a mesh that is none", &|_, blocks| blocks[0][36] = 1),
        ("a triangle that is none", &|_, blocks| blocks[0][40] = 3200),
        ("another triangle", &|_, blocks| blocks[0][40] ^= 1),
        ("other corners", &|_, blocks| blocks[0][0] ^= 1),
    ];
    for (what, change) in breaks {
        let (mut nodes, mut blocks) = (nodes.clone(), blocks.clone());
        change(&mut nodes, &mut blocks);
        assert!(take(&nodes, &blocks, &meshes).is_none(), "{what}");
    }
    // A chain of nodes deeper than the traversal has room for.
    let mut chain = vec![nodes[0]; 200];
    for (index, node) in chain.iter_mut().enumerate() {
        node[48..].fill(0);
        node[48] = index as u32 + 1;
    }
    chain[199][48] = 1 << 31;
    assert!(take(&chain, &blocks, &meshes).is_none());
    assert!(take(&nodes, &blocks, &meshes).is_some());
    assert!(take(&nodes, &blocks, &sheet(39)).is_none());
    for leaves_of_one in [0.5, 17.0, f64::NAN] {
        assert!(Stored::default().finish(&[], leaves_of_one, None).is_none());
    }
}
