#include "model/portable_math.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <span>

namespace ctn::model {
namespace {

// Highest power first.
double polynomial(std::span<const double> coefficients, double x) {
  double sum = 0.0;
  for (const double coefficient : coefficients) sum = sum * x + coefficient;
  return sum;
}

}  // namespace

double portable_exp(double x) {
  assert(std::abs(x) <= 700.0);
  // x = k ln 2 + r, so that |r| <= ln(2) / 2, where 16 terms of the series are more than enough.
  const double k = std::floor(x / std::numbers::ln2 + 0.5);
  const double r = x - k * std::numbers::ln2;
  double sum = 1.0;
  for (int n = 16; n >= 1; --n) sum = 1.0 + sum * r / n;
  return std::ldexp(sum, static_cast<int>(k));
}

double portable_log(double x) {
  assert(x > 0.0 && std::isfinite(x));
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // in [0.5, 1)
  if (mantissa < std::numbers::sqrt2 / 2.0) {
    mantissa *= 2.0;
    --exponent;
  }
  // log m = 2 artanh(s), |s| <= 0.172.
  const double s = (mantissa - 1.0) / (mantissa + 1.0);
  double sum = 0.0;
  for (int n = 21; n >= 1; n -= 2) sum = sum * s * s + 1.0 / n;
  return 2.0 * s * sum + exponent * std::numbers::ln2;
}

// P. J. Acklam's rational approximations: one for the middle, one for each tail.
double inverse_normal(double probability) {
  assert(probability > 0.0 && probability < 1.0);
  constexpr std::array kMiddleOver{-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                                   1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr std::array kMiddleUnder{-5.447609879822406e+01, 1.615858368580409e+02,  -1.556989798598866e+02,
                                    6.680131188771972e+01,  -1.328068155288572e+01, 1.0};
  constexpr std::array kTailOver{-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                                 -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
  constexpr std::array kTailUnder{7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                                  3.754408661907416e+00, 1.0};
  constexpr double kTail = 0.02425;
  const auto tail = [&](double outside) {
    const double q = std::sqrt(-2.0 * portable_log(outside));
    return polynomial(kTailOver, q) / polynomial(kTailUnder, q);
  };
  if (probability < kTail) return tail(probability);
  if (probability > 1.0 - kTail) return -tail(1.0 - probability);
  const double q = probability - 0.5;
  return q * polynomial(kMiddleOver, q * q) / polynomial(kMiddleUnder, q * q);
}

}  // namespace ctn::model
