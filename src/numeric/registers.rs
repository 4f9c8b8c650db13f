//! Clears the upper halves of the AVX registers after faer products (VZEROUPPER).
//!
//! On x86-64 the kernels of faer's products return with the upper halves of the vector registers in use. From then on every
//! instruction of code built for any x86-64 waits for what those halves held: measured, sums of exponentials took ten times
//! as long until a function that clears them was called. The compiler ends every function with AVX2 in it by clearing them.

/// Clears the upper halves of the vector registers, in some ten nanoseconds; to be called where scalar work follows products.
pub fn zero_upper() {
    // Longer than one register, so that the search goes by AVX2 where there is AVX2.
    const NOTHING: [u8; 64] = [0; 64];
    std::hint::black_box(memchr::memchr(1, std::hint::black_box(&NOTHING)));
}
