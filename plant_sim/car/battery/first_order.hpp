// SPDX-License-Identifier: Apache-2.0
// The exact step of everything in a cell that lags: dv/dt = (u - v) / tau over an interval dt.
//
//   u straight from u_a to u_b     v' = a v + g0 u_a + g1 u_b,   a = exp(-dt/tau),  x = tau/dt (1 - a),
//                                  g0 = x - a,  g1 = 1 - x
//                                  mean of v = (u_a + u_b)/2 - tau/dt (v' - v)
//   u constant, u = R i            v' = a v + (1 - a) R i,   mean of v = x v + (1 - x) R i
//
// RC branches (u = R I), a surface behind its cell (u = T), a cell's temperature (u where it would settle).
#pragma once
#include <cmath>

namespace voltlap::plant {

/// What an interval leaves of v, and what it takes from both ends of u; their sum is 1.
struct FirstOrderStep {
  double keep, from_begin, from_end;

  [[nodiscard]] double after(double v, double u_begin, double u_end) const {
    return keep * v + from_begin * u_begin + from_end * u_end;
  }
};

/// `dt_s` and `tau_s` more than 0.
[[nodiscard]] inline FirstOrderStep first_order_step(double dt_s, double tau_s) {
  const double a = std::exp(-dt_s / tau_s), x = tau_s / dt_s * (1.0 - a);
  return {a, x - a, 1.0 - x};
}

/// Mean of v over the interval in which it went from `v` to `after`.
[[nodiscard]] inline double first_order_mean(double v, double after, double u_mean, double dt_s, double tau_s) {
  return u_mean - tau_s / dt_s * (after - v);
}

/// A branch of `ohm` over steps of constant current, all of one length: v' = decay v + gain i, mean of v =
/// mean_decay v + mean_gain i.
struct HeldBranch {
  double decay, gain, mean_decay, mean_gain;
};

[[nodiscard]] inline HeldBranch held_branch(double dt_s, double tau_s, double ohm) {
  const double decay = std::exp(-dt_s / tau_s), mean_decay = tau_s * (1.0 - decay) / dt_s;
  return {decay, (1.0 - decay) * ohm, mean_decay, (1.0 - mean_decay) * ohm};
}

}  // namespace voltlap::plant
