// SPDX-License-Identifier: Apache-2.0
// Nodes that were lost, and how long the car then took to have no torque and open contactors.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/demand.hpp"
#include "io/bus/plant_bus.hpp"

namespace voltlap::plant {

/// A node that was lost on the way, and how the car came to rest electrically.
struct LostNodeRow {
  std::string node;
  double time_s;                            ///< since power-on
  std::optional<double> torque_zero_s;      ///< from the loss until the phase current was zero for good
  std::optional<double> contactors_open_s;  ///< ... until both AIRs were open for good
};

class TimeToSafeState {
 public:
  explicit TimeToSafeState(double tick_s) : tick_s_(tick_s) {}

  /// After every tick: all nodes lost so far, and the car as it is now.
  void observe(std::uint32_t tick, const std::vector<LostNode>& lost, bool torque, bool contactors_closed) {
    VOLTLAP_DEMAND(tick >= now_ && lost.size() >= watched_.size());
    while (watched_.size() < lost.size()) {
      const LostNode& node = lost[watched_.size()];
      watched_.push_back({node.node, node.drives, tick, tick, tick});
      if (node.drives && !first_) first_ = tick;
    }
    for (Watched& w : watched_) {
      if (torque) w.torque_until = tick + 1;
      if (contactors_closed) w.closed_until = tick + 1;
    }
    torque_ = torque;
    closed_ = contactors_closed;
    now_ = tick;
  }
  /// A control unit is lost.
  [[nodiscard]] bool car_is_lost() const { return first_.has_value(); }
  /// ... for so long that what the car does about it can be told.
  [[nodiscard]] bool settled() const { return first_ && (now_ - *first_) * tick_s_ >= kSettle_s; }

  [[nodiscard]] std::vector<LostNodeRow> rows() const {
    std::vector<LostNodeRow> out;
    for (const Watched& w : watched_) {
      const auto after = [&](std::uint32_t until) { return (until - w.lost) * tick_s_; };
      out.push_back({w.node, w.lost * tick_s_, torque_ ? std::nullopt : std::optional(after(w.torque_until)),
                     closed_ ? std::nullopt : std::optional(after(w.closed_until))});
    }
    return out;
  }

 private:
  static constexpr double kSettle_s = 1.0;  // every time-out of the car is far below

  struct Watched {
    std::string node;
    bool drives;
    std::uint32_t lost, torque_until, closed_until;  ///< ticks
  };

  double tick_s_;
  std::vector<Watched> watched_;
  std::optional<std::uint32_t> first_;
  std::uint32_t now_ = 0;
  bool torque_ = false, closed_ = false;
};

}  // namespace voltlap::plant
