// SPDX-License-Identifier: Apache-2.0
// The DC link: its capacitor between the pack's path and the loads, solved implicitly, because pack resistance times
// capacitance (about 60 us) is far below the step.
//
//   C (V - V_before)/dt = (V_th - V) / R - P/V - V/R_bleed        a quadratic in V; the upper root is the stable one
#pragma once
#include <cmath>
#include <utility>

#include "core/parameters.hpp"

namespace voltlap::plant {

struct DcLinkStep {
  double pack_current_a = 0.0;
  double load_j = 0.0;     ///< taken by the constant-power loads
  double bleed_j = 0.0;    ///< in the bleed resistor
  double path_j = 0.0;     ///< in contactors or precharge resistor
  double stored_j = 0.0;   ///< into the capacitor
  bool collapsed = false;  ///< the pack could not deliver the power that was asked
};

class DcLink {
 public:
  explicit DcLink(const ContactorSection& section) : section_(section) {}

  /// One step. Pack: open-circuit voltage `source_v` behind `source_ohm`; path conductance in siemens; load in watts.
  DcLinkStep advance(double source_v, double source_ohm, double path_siemens, double load_w, double step_s) {
    const double before = voltage_;
    const double path = path_of(source_ohm, path_siemens);
    const auto [a, b] = quadratic(source_v, path, step_s);
    DcLinkStep out;
    out.collapsed = b * b < 4.0 * a * load_w;
    voltage_ = upper_root(a, b, load_w);
    const double load = out.collapsed ? b * b / (4.0 * a) : load_w;
    out.pack_current_a = path > 0.0 ? path * (source_v - voltage_) : 0.0;
    out.load_j = load * step_s;
    out.bleed_j = voltage_ * voltage_ / section_.bleed_resistance_ohm * step_s;
    out.path_j = path_siemens > 0.0 ? out.pack_current_a * out.pack_current_a / path_siemens * step_s : 0.0;
    out.stored_j = section_.dc_link_capacitance_f * (voltage_ - before) * voltage_;
    return out;
  }
  [[nodiscard]] double voltage() const { return voltage_; }
  /// What `advance` would leave.
  [[nodiscard]] double voltage_under(double source_v, double source_ohm, double path_siemens, double load_w,
                                     double step_s) const {
    const auto [a, b] = quadratic(source_v, path_of(source_ohm, path_siemens), step_s);
    return upper_root(a, b, load_w);
  }

 private:
  static double path_of(double source_ohm, double path_siemens) {
    return path_siemens > 0.0 ? 1.0 / (source_ohm + 1.0 / path_siemens) : 0.0;
  }
  /// a and b of a V^2 - b V + P = 0.
  [[nodiscard]] std::pair<double, double> quadratic(double source_v, double path, double step_s) const {
    const double capacitive = section_.dc_link_capacitance_f / step_s;
    return {capacitive + path + 1.0 / section_.bleed_resistance_ohm, capacitive * voltage_ + path * source_v};
  }
  static double upper_root(double a, double b, double load_w) {
    const double root = b * b - 4.0 * a * load_w;
    return root < 0.0 ? b / (2.0 * a) : (b + std::sqrt(root)) / (2.0 * a);
  }

  ContactorSection section_;
  double voltage_ = 0.0;
};

}  // namespace voltlap::plant
