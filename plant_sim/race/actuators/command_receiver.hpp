// SPDX-License-Identifier: Apache-2.0
// The plant's side of the bus: commands of the ECUs become switches and currents.
#pragma once
#include "base/can_frame.hpp"
#include "base/time.hpp"
#include <array>

#include "can_dbc/car.hpp"
#include "can_dbc/charger.hpp"
#include "can_dbc/pm100.hpp"
#include "can_dbc/tables.hpp"
#include "car/car.hpp"
#include "codec/amk_frames.hpp"
#include "codec/rx_monitor.hpp"

namespace voltlap::plant {

/// What the ECUs last said, for actuators and for the result.
class CommandReceiver {
 public:
  /// Takes in frames and moves contactors and inverter of the car; silence of a command opens or stops them.
  void receive(Instant now, FrameView frames, Car& car);

  [[nodiscard]] const can::BmsLimits& limits() const { return limits_; }
  [[nodiscard]] const can::BmsStatus& bms() const { return bms_; }
  [[nodiscard]] const can::MasterStatus& master() const { return master_; }
  /// With the channel that the BMS does not believe, or the cell that it could not balance.
  [[nodiscard]] const can::ContactorCommand& contactors() const { return contactors_; }
  /// Of a car on a charger; all zero otherwise.
  [[nodiscard]] const can::ChargeStatus& charge() const { return charge_; }

 private:
  /// A silent node has no state: what it last said must not stand for ever.
  template <class Message>
  void forget_unless_fresh(Instant now, Message& last) {
    if (!monitor_.fresh(Message::kId, now)) last = {};
  }

  static void take_pm100(const can::Pm100Command& m, Car& car);
  static void drive_by_pm100(Car& car);
  static void take_amk(const codec::AmkSetpoints& m, MotorDrive& drive);
  static void drive_by_amk(Car& car);

  /// The shunts as they were last told; silence ends them, group by group.
  void take_balancing(const can::BalancingCommand& m, Car& car);
  void end_silent_balancing(Instant now, Car& car);
  void move_shunts(Car& car) const;

  static constexpr std::size_t kWords = can::BalancingCommand::kGroups * can::BalancingCommand::kPerFrame;

  codec::RxMonitor<can::kPlantRx> monitor_;
  std::array<std::uint32_t, kWords> bled_{};
  can::ContactorCommand contactors_{};
  can::BmsLimits limits_{};
  can::BmsStatus bms_{};
  can::MasterStatus master_{};
  can::ChargeStatus charge_{};
};

}  // namespace voltlap::plant
