// SPDX-License-Identifier: Apache-2.0
// The DC link: its capacitor between the pack's path and the loads, solved implicitly, because pack resistance times
// capacitance (about 60 us) is far below the step.
//
//   C (V - V_before)/dt = (V_th - V) / R - P/V - V/R_bleed        a quadratic in V; the upper root is the stable one
#pragma once
#include <cmath>

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
    const double path = path_siemens > 0.0 ? 1.0 / (source_ohm + 1.0 / path_siemens) : 0.0;
    const double a = section_.dc_link_capacitance_f / step_s + path + 1.0 / section_.bleed_resistance_ohm;
    const double b = section_.dc_link_capacitance_f / step_s * before + path * source_v;
    const double root = b * b - 4.0 * a * load_w;
    DcLinkStep out;
    out.collapsed = root < 0.0;
    voltage_ = out.collapsed ? b / (2.0 * a) : (b + std::sqrt(root)) / (2.0 * a);
    const double load = out.collapsed ? b * b / (4.0 * a) : load_w;
    out.pack_current_a = path > 0.0 ? path * (source_v - voltage_) : 0.0;
    out.load_j = load * step_s;
    out.bleed_j = voltage_ * voltage_ / section_.bleed_resistance_ohm * step_s;
    out.path_j = path_siemens > 0.0 ? out.pack_current_a * out.pack_current_a / path_siemens * step_s : 0.0;
    out.stored_j = section_.dc_link_capacitance_f * (voltage_ - before) * voltage_;
    return out;
  }
  [[nodiscard]] double voltage() const { return voltage_; }

 private:
  ContactorSection section_;
  double voltage_ = 0.0;
};

}  // namespace voltlap::plant
