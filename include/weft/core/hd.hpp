#pragma once

/// Marks a function that both the host compiler and nvcc compile.
#if defined(__CUDACC__)
#define WEFT_HD __host__ __device__
#else
#define WEFT_HD
#endif
