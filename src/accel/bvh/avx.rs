//! The two kernels as AVX intrinsics: eight boxes, four triangles. The operations of [`super::node`] and
//! [`super::triangle`], one for one; MINPS and MAXPS treat NaN exactly as `min` and `max` there do.
#![allow(unsafe_code)]

use super::node::{MARGIN, Node, WIDTH};
use super::ray::Prepared;
use super::triangle::{BLOCK, Block, Met};
use std::arch::x86_64::*;

/// As [`Node::enter`].
#[inline(always)]
pub unsafe fn enter(node: &Node, rays: &Prepared, i: usize, tmax: f32) -> ([f32; WIDTH], u32) {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe {
        let mut near = _mm256_set1_ps(rays.tmin[i]);
        let mut far = _mm256_set1_ps(tmax);
        for k in 0..3 {
            let side = rays.near_side[k][i] as usize & 1;
            let (first, last) = (load8(&node.planes[k][side]), load8(&node.planes[k][side ^ 1]));
            let inverse = _mm256_set1_ps(rays.inverse[k][i]);
            let first = _mm256_fmsub_ps(first, inverse, _mm256_set1_ps(rays.near_start[k][i]));
            let last = _mm256_fmsub_ps(last, inverse, _mm256_set1_ps(rays.far_start[k][i]));
            near = _mm256_max_ps(first, near);
            far = _mm256_min_ps(last, far);
        }
        let met = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
        let mut out = Near([0.0; WIDTH]);
        _mm256_store_ps(out.0.as_mut_ptr(), near);
        (out.0, met as u32)
    }
}

#[repr(align(32))]
struct Near([f32; WIDTH]);

/// As [`Block::meet`].
#[inline(always)]
pub unsafe fn meet(block: &Block, rays: &Prepared, i: usize, tmax: f32) -> Met {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe {
        let [kx, ky, kz] = [0, 1, 2].map(|k| rays.axes[k][i] as usize);
        let [ox, oy, oz] = [0, 1, 2].map(|k| _mm_set1_ps(rays.origin[k][i]));
        let (sx, sy) = (_mm_set1_ps(rays.shear[0][i]), _mm_set1_ps(rays.shear[1][i]));
        let (mut x, mut y, mut z) = ([_mm_setzero_ps(); 3], [_mm_setzero_ps(); 3], [_mm_setzero_ps(); 3]);
        for (corner, planes) in block.corners.iter().enumerate() {
            let pz = _mm_sub_ps(load4(&planes[kz]), oz);
            x[corner] = _mm_sub_ps(_mm_sub_ps(load4(&planes[kx]), ox), _mm_mul_ps(sx, pz));
            y[corner] = _mm_sub_ps(_mm_sub_ps(load4(&planes[ky]), oy), _mm_mul_ps(sy, pz));
            z[corner] = pz;
        }
        let edge = |a: usize, b: usize| _mm_sub_ps(_mm_mul_ps(x[a], y[b]), _mm_mul_ps(y[a], x[b]));
        let (u, v, w) = (edge(2, 1), edge(0, 2), edge(1, 0));
        let (least, most) = (_mm_min_ps(_mm_min_ps(u, v), w), _mm_max_ps(_mm_max_ps(u, v), w));
        let zero = _mm_setzero_ps();
        let candidates = _mm_or_ps(_mm_cmpge_ps(least, zero), _mm_cmple_ps(most, zero));
        if _mm_movemask_ps(candidates) == 0 {
            return (0, [0.0; BLOCK]);
        }
        let (distances, hit) = distances(x, y, z, rays.inverse_z[i]);
        let (near, far) = box_interval(block, rays, i);
        let t = _mm_max_ps(_mm_min_ps(distances, far), near);
        let on = _mm_and_ps(_mm_cmpge_ps(t, _mm_set1_ps(rays.tmin[i])), _mm_cmple_ps(t, _mm_set1_ps(tmax)));
        let met = _mm_and_ps(_mm_and_ps(on, _mm_cmple_ps(near, far)), candidates);
        let mut out = [0.0; BLOCK];
        _mm_storeu_ps(out.as_mut_ptr(), t);
        ((_mm_movemask_ps(met) & hit) as u32, out)
    }
}

/// Distances in f64, and one bit for each triangle that is met and not seen edge-on.
#[inline(always)]
unsafe fn distances(x: [__m128; 3], y: [__m128; 3], z: [__m128; 3], inverse_z: f64) -> (__m128, i32) {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe {
        let [x, y, z] = [wide(x), wide(y), wide(z)];
        let edge = |a: usize, b: usize| _mm256_sub_pd(_mm256_mul_pd(x[a], y[b]), _mm256_mul_pd(y[a], x[b]));
        let (u, v, w) = (edge(2, 1), edge(0, 2), edge(1, 0));
        let zero = _mm256_setzero_pd();
        let (least, most) = (_mm256_min_pd(_mm256_min_pd(u, v), w), _mm256_max_pd(_mm256_max_pd(u, v), w));
        let one_sign =
            _mm256_or_pd(_mm256_cmp_pd::<_CMP_GE_OQ>(least, zero), _mm256_cmp_pd::<_CMP_LE_OQ>(most, zero));
        let det = _mm256_add_pd(_mm256_add_pd(u, v), w);
        let faces = _mm256_cmp_pd::<_CMP_NEQ_UQ>(det, zero);
        let inverse = _mm256_div_pd(_mm256_set1_pd(1.0), det);
        let sum = _mm256_add_pd(
            _mm256_add_pd(_mm256_mul_pd(u, z[0]), _mm256_mul_pd(v, z[1])),
            _mm256_mul_pd(w, z[2]),
        );
        let t = _mm256_mul_pd(_mm256_mul_pd(sum, inverse), _mm256_set1_pd(inverse_z));
        (_mm256_cvtpd_ps(t), _mm256_movemask_pd(_mm256_and_pd(one_sign, faces)))
    }
}

/// Where the ray enters and leaves each triangle's own box, enlarged and computed as a node's.
#[inline(always)]
unsafe fn box_interval(block: &Block, rays: &Prepared, i: usize) -> (__m128, __m128) {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe {
        let [a, b, c] = &block.corners;
        let sign = _mm_set1_ps(-0.0);
        let (mut lo, mut hi, mut largest) = ([sign; 3], [sign; 3], _mm_setzero_ps());
        for k in 0..3 {
            let (a, b, c) = (load4(&a[k]), load4(&b[k]), load4(&c[k]));
            lo[k] = _mm_min_ps(_mm_min_ps(a, b), c);
            hi[k] = _mm_max_ps(_mm_max_ps(a, b), c);
            let w = _mm_max_ps(_mm_andnot_ps(sign, lo[k]), _mm_andnot_ps(sign, hi[k]));
            largest = _mm_max_ps(w, largest);
        }
        let e = _mm_add_ps(_mm_mul_ps(largest, _mm_set1_ps(MARGIN)), _mm_set1_ps(f32::MIN_POSITIVE));
        let (mut near, mut far) = (_mm_set1_ps(f32::NEG_INFINITY), _mm_set1_ps(f32::INFINITY));
        for k in 0..3 {
            let inverse = _mm_set1_ps(rays.inverse[k][i]);
            let (lo, hi) = (_mm_sub_ps(lo[k], e), _mm_add_ps(hi[k], e));
            // Picked by the sign bit of 1/d.
            let (first, last) = (_mm_blendv_ps(lo, hi, inverse), _mm_blendv_ps(hi, lo, inverse));
            let first = _mm_fmsub_ps(first, inverse, _mm_set1_ps(rays.near_start[k][i]));
            let last = _mm_fmsub_ps(last, inverse, _mm_set1_ps(rays.far_start[k][i]));
            near = _mm_max_ps(near, first);
            far = _mm_min_ps(far, last);
        }
        (near, far)
    }
}

/// Fetches the first `lines` cache lines of what `place` refers to.
#[inline(always)]
pub fn prefetch<T>(place: &T, lines: usize) {
    let first = (&raw const *place).cast::<i8>();
    for line in 0..lines {
        // SAFETY: a hint, allowed for any address; SSE is part of x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(64 * line)) };
    }
}

#[inline(always)]
unsafe fn load8(from: &[f32; WIDTH]) -> __m256 {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe { _mm256_loadu_ps(from.as_ptr()) }
}

#[inline(always)]
unsafe fn load4(from: &[f32; BLOCK]) -> __m128 {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe { _mm_loadu_ps(from.as_ptr()) }
}

#[inline(always)]
unsafe fn wide([a, b, c]: [__m128; 3]) -> [__m256d; 3] {
    // SAFETY: the caller answers for AVX2 and FMA; loads and stores are as wide as what they are given.
    unsafe { [_mm256_cvtps_pd(a), _mm256_cvtps_pd(b), _mm256_cvtps_pd(c)] }
}
