// SPDX-License-Identifier: Apache-2.0
// AIR+, AIR- and the precharge contactor with its resistor: travel times, welded and open faults, and the resistance
// of the path from the pack to the DC link.
#pragma once
#include "core/parameters.hpp"

namespace voltlap::plant {

/// A fault of one contactor or of the precharge resistor, planted by a test or a scenario.
enum class ContactorFault { kNone, kWelded, kOpen };

class Contactor {
 public:
  void command(bool close) { commanded_ = close; }
  void set_fault(ContactorFault fault) { fault_ = fault; }
  void advance(double elapsed_s, double close_time_s, double open_time_s) {
    travel_s_ = commanded_ == moved_ ? 0.0 : travel_s_ + elapsed_s;
    if (travel_s_ > (commanded_ ? close_time_s : open_time_s)) {
      moved_ = commanded_;
      travel_s_ = 0.0;
    }
  }
  [[nodiscard]] bool closed() const {
    return fault_ == ContactorFault::kWelded || (fault_ == ContactorFault::kNone && moved_);
  }

 private:
  bool commanded_ = false, moved_ = false;
  double travel_s_ = 0.0;
  ContactorFault fault_ = ContactorFault::kNone;
};

class ContactorBox {
 public:
  explicit ContactorBox(const ContactorSection& section) : section_(section) {}

  Contactor air_plus, air_minus, precharge;
  bool precharge_resistor_open = false;  ///< planted fault

  void advance(double elapsed_s) {
    for (Contactor* c : {&air_plus, &air_minus, &precharge}) {
      c->advance(elapsed_s, section_.close_time_s, section_.open_time_s);
    }
  }
  [[nodiscard]] bool main_closed() const { return air_plus.closed() && air_minus.closed(); }
  /// Conductance [S] from the pack's terminals to the DC link; 0 when the path is open.
  [[nodiscard]] double conductance() const {
    if (!air_minus.closed()) return 0.0;
    const double main = air_plus.closed() ? 1.0 / section_.resistance_ohm : 0.0;
    const double side = precharge.closed() && !precharge_resistor_open ? 1.0 / section_.precharge_resistance_ohm : 0.0;
    return main + side;
  }

 private:
  ContactorSection section_;
};

}  // namespace voltlap::plant
