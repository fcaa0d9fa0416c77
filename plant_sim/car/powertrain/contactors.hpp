// SPDX-License-Identifier: Apache-2.0
// AIR+, AIR- and the precharge contactor with its resistor: travel times, faults (welded, open, slow, chattering), and
// the resistance of the path from the pack to the DC link.
#pragma once
#include <cmath>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// A fault of one contactor or of the precharge resistor, planted by a test or a scenario.
enum class ContactorFault { kNone, kWelded, kOpen, kChattering };

class Contactor {
 public:
  void command(bool close) { commanded_ = close; }
  void set_fault(ContactorFault fault) { fault_ = fault; }
  /// A coil that loses its hold: closed for so long, open for so long, as long as it is commanded to close.
  void chatter(double half_period_s) {
    fault_ = ContactorFault::kChattering;
    half_period_s_ = half_period_s;
    chatter_s_ = 0.0;
  }
  /// A coil or spring that drags: added to the travel both ways.
  void set_slow(double more_s) { slow_s_ = more_s; }
  void advance(double elapsed_s, double close_time_s, double open_time_s) {
    chatter_s_ += elapsed_s;
    travel_s_ = commanded_ == moved_ ? 0.0 : travel_s_ + elapsed_s;
    if (travel_s_ > (commanded_ ? close_time_s : open_time_s) + slow_s_) {
      moved_ = commanded_;
      travel_s_ = 0.0;
    }
  }
  [[nodiscard]] bool closed() const {
    switch (fault_) {
      case ContactorFault::kNone: return moved_;
      case ContactorFault::kWelded: return true;
      case ContactorFault::kOpen: return false;
      case ContactorFault::kChattering: return moved_ && std::fmod(chatter_s_, 2.0 * half_period_s_) >= half_period_s_;
    }
    return false;
  }

 private:
  bool commanded_ = false, moved_ = false;
  double travel_s_ = 0.0, slow_s_ = 0.0;
  double half_period_s_ = 0.0, chatter_s_ = 0.0;  // since it chatters, open first
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
