// Functions whose last bits are the same on every machine, compiler and optimisation level, for draws that must be.
//
// The C library's exp and log are accurate but not exact, and differ between its versions; std::normal_distribution
// differs between standard libraries. These use nothing but additions, multiplications, divisions, square roots and
// scaling by powers of two, which IEEE 754 defines to the last bit; the build keeps the compiler from fusing them.
//
// Relative error: exp and log below 1e-13, inverse_normal below 2e-9 (in z). Thread safety: pure functions.
#pragma once

namespace ctn::model {

// Precondition: |x| <= 700.
double portable_exp(double x);

// Precondition: x > 0, finite and not subnormal.
double portable_log(double x);

// The z that a standard normal variable stays below with that probability. Precondition: 0 < probability < 1.
double inverse_normal(double probability);

}  // namespace ctn::model
