//! A mesh, written in every format.

use std::fmt::Write as _;
use std::io::Write as _;

/// A dented ring of triangles; numbers that decimals and f32 hold exactly.
pub struct Ring {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub triangles: Vec<[usize; 3]>,
}

impl Ring {
    pub fn new() -> Ring {
        const AROUND: usize = 12;
        const ACROSS: usize = 8;
        let dyadic = |x: f64| (x * 256.0).round() as f32 / 256.0;
        let turn = |i: usize, n: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..AROUND {
            for j in 0..ACROSS {
                let (a, b) = (turn(i, AROUND), turn(j, ACROSS));
                let out = 1.0 + (0.4 + 0.1 * (3.0 * a).sin()) * b.cos();
                positions.push([out * a.cos(), 0.4 * b.sin(), out * a.sin()].map(dyadic));
                normals.push([b.cos() * a.cos(), b.sin(), b.cos() * a.sin()].map(dyadic));
                let at = |i: usize, j: usize| i % AROUND * ACROSS + j % ACROSS;
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
            }
        }
        Ring { positions, normals, triangles }
    }

    pub fn obj(&self, smooth: bool) -> Vec<u8> {
        let mut out = String::new();
        self.positions.iter().for_each(|[x, y, z]| writeln!(out, "v {x} {y} {z}").unwrap());
        if smooth {
            self.normals.iter().for_each(|[x, y, z]| writeln!(out, "vn {x} {y} {z}").unwrap());
        }
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| if smooth { format!("{0}//{0}", i + 1) } else { (i + 1).to_string() });
            writeln!(out, "f {a} {b} {c}").unwrap();
        }
        out.into_bytes()
    }

    pub fn ply(&self, format: &str, smooth: bool) -> Vec<u8> {
        let mut header = format!("ply\nformat {format} 1.0\nelement vertex {}\n", self.positions.len());
        for name in if smooth { ["x", "y", "z", "nx", "ny", "nz"].as_slice() } else { &["x", "y", "z"] } {
            writeln!(header, "property float {name}").unwrap();
        }
        writeln!(header, "element face {}\nproperty list uchar int vertex_indices", self.triangles.len())
            .unwrap();
        let mut out = (header + "end_header\n").into_bytes();
        for (position, normal) in self.positions.iter().zip(&self.normals) {
            let row: Vec<f32> = position.iter().chain(normal.iter().filter(|_| smooth)).copied().collect();
            match format {
                "ascii" => row.iter().for_each(|x| write!(out, "{x} ").unwrap()),
                "binary_big_endian" => out.extend(row.iter().flat_map(|x| x.to_be_bytes())),
                _ => out.extend(row.iter().flat_map(|x| x.to_le_bytes())),
            }
        }
        for t in &self.triangles {
            let row = t.map(|i| i as i32);
            match format {
                "ascii" => write!(out, "\n3 {} {} {}", row[0], row[1], row[2]).unwrap(),
                "binary_big_endian" => {
                    out.extend([3].into_iter().chain(row.iter().flat_map(|i| i.to_be_bytes())))
                }
                _ => out.extend([3].into_iter().chain(row.iter().flat_map(|i| i.to_le_bytes()))),
            }
        }
        out
    }

    pub fn stl(&self, is_text: bool) -> Vec<u8> {
        let mut out = if is_text { b"solid ring\n".to_vec() } else { vec![b' '; 80] };
        if !is_text {
            out.extend((self.triangles.len() as u32).to_le_bytes());
        }
        for t in &self.triangles {
            let corners = t.map(|i| self.positions[i]);
            if is_text {
                out.extend(b"facet normal 0 0 0\nouter loop\n");
                corners.iter().for_each(|[x, y, z]| writeln!(out, "vertex {x} {y} {z}").unwrap());
                out.extend(b"endloop\nendfacet\n");
            } else {
                out.extend([0; 12]);
                out.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
                out.extend([0; 2]);
            }
        }
        out
    }

    /// The JSON of a document whose buffer is `uri`, or behind it, and the buffer.
    pub fn gltf(&self, smooth: bool, uri: Option<&str>) -> (Vec<u8>, Vec<u8>) {
        let vectors =
            |list: &[[f32; 3]]| list.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let indices = self.triangles.iter().flatten().flat_map(|i| (*i as u16).to_le_bytes());
        let data = [vectors(&self.positions), vectors(&self.normals), indices.collect()].concat();
        let (count, size) = (self.positions.len(), 12 * self.positions.len());
        let indices = 3 * self.triangles.len();
        let normal = if smooth { ", \"NORMAL\": 1" } else { "" };
        let uri = uri.map(|uri| format!(", \"uri\": \"{uri}\"")).unwrap_or_default();
        let text = format!(
            "{{ \"asset\": {{ \"version\": \"2.0\" }}, \"buffers\": [{{ \"byteLength\": {}{uri} }}],
            \"bufferViews\": [
                {{ \"buffer\": 0, \"byteLength\": {size} }},
                {{ \"buffer\": 0, \"byteOffset\": {size}, \"byteLength\": {size} }},
                {{ \"buffer\": 0, \"byteOffset\": {}, \"byteLength\": {} }}],
            \"accessors\": [
                {{ \"bufferView\": 0, \"componentType\": 5126, \"count\": {count}, \"type\": \"VEC3\" }},
                {{ \"bufferView\": 1, \"componentType\": 5126, \"count\": {count}, \"type\": \"VEC3\" }},
                {{ \"bufferView\": 2, \"componentType\": 5123, \"count\": {indices}, \"type\": \"SCALAR\" }}],
            \"meshes\": [{{ \"primitives\": [
                {{ \"attributes\": {{ \"POSITION\": 0{normal} }}, \"indices\": 2 }}] }}],
            \"nodes\": [{{ \"mesh\": 0 }}], \"scenes\": [{{ \"nodes\": [0] }}] }}",
            data.len(),
            2 * size,
            2 * indices,
        );
        (text.into_bytes(), data)
    }

    pub fn glb(&self, smooth: bool) -> Vec<u8> {
        let (mut text, mut data) = self.gltf(smooth, None);
        text.resize(text.len().next_multiple_of(4), b' ');
        data.resize(data.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((28 + text.len() as u32 + data.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", data)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }
}
