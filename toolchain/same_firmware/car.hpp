// SPDX-License-Identifier: Apache-2.0
// A drawn car and its driver: plausible enough that both nodes get into all their states, in seconds instead of laps.
// It hears what the nodes send, closes contactors, charges the DC link, turns the motor, and has its troubles.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "can_dbc/car.hpp"
#include "can_dbc/tables.hpp"
#include "draw.hpp"
#include "node_api.hpp"

namespace same_firmware {

namespace can = voltlap::can;

/// What the nodes have sent last.
struct Heard {
  can::ContactorCommand contactors;
  can::InverterCommand inverter;
  can::BmsLimits limits;
  can::BmsStatus bms;
  can::MasterStatus master;

  void read(const voltlap::Frame& frame);
};

/// What can be wrong in the car, for a time.
enum class Trouble : std::uint8_t {
  kShutdownOpen, kContactWelded, kContactOpen, kLinkHigh, kLinkLow, kCellLow, kCellHigh, kCellInvalid,
  kPackAtLimit, kThermistorInvalid, kCurrentAtLimit, kCurrentInvalid, kVoltageOff, kAppsOffset, kAppsRange,
  kBothPedals, kBrakeInvalid, kWheelsInvalid, kInverterFault, kInverterSilent, kMotorHot, kInverterHot, kNoSpeed,
  kReverse, kButtonsStuck,
};
inline constexpr std::size_t kTroubles = static_cast<std::size_t>(Trouble::kButtonsStuck) + 1;

class Car {
 public:
  Car(const Settings& settings, Draw& draw);

  /// A trouble of a drawn kind and duration.
  void plant_trouble();
  void step(const Heard& heard);
  /// Every message that is due, in the order of a plant; `send` takes each.
  template <class Send>
  void send(std::uint32_t now_ms, Send&& send) const;

 private:
  struct Active {
    Trouble kind;
    std::int32_t index;  ///< of a cell, a contact, a sensor
    std::int32_t size;   ///< how far off, drawn
    std::int32_t ticks_left;
  };

  void drive(const Heard& heard);
  void press_buttons(const Heard& heard);
  void move_contactors(const Heard& heard);
  void move_motor(const Heard& heard);
  void heat();
  void set_cells();
  void suffer(const Active& trouble);
  void suffer_in_pack(const Active& trouble);
  [[nodiscard]] can::CellVoltages cells(std::size_t group) const;
  [[nodiscard]] can::Temperatures temperatures(std::size_t group) const;

  BmsSettings settings_;
  Draw& draw_;
  std::vector<Active> troubles_;

  // drawn once
  double soc_, soc_per_amp_tick_, resistance_, motor_heat_, pack_heat_, excess_;
  std::int32_t link_ticks_, contact_ticks_;
  std::vector<std::int32_t> cell_offset_;

  // the driver
  std::int32_t pedal_permille_ = 0, brake_mbar_ = 0, button_ticks_ = 0, foot_ticks_ = 0;
  bool button_down_ = false;

  double pack_c_ = 25.0, motor_c_ = 40.0, speed_rpm_ = 0.0;
  std::array<std::int32_t, 3> contact_ticks_left_{};
  std::array<bool, 3> closed_{};

  // as the sensors see it
  can::PackSensor pack_;
  can::Pedals pedals_;
  can::WheelSpeeds wheels_;
  can::InverterStatus inverter_;
  can::VehicleIo io_;
  can::MotorTemperatures motor_;
  std::vector<std::int32_t> cell_, temperature_dc_;
  std::vector<bool> cell_ok_, temperature_ok_;
  bool inverter_sends_ = true;
};

template <class Send>
void Car::send(std::uint32_t now_ms, Send&& send) const {
  send(pack_);
  send(pedals_);
  send(wheels_);
  if (inverter_sends_) send(inverter_);
  send(io_);
  if (can::due(now_ms, can::MotorTemperatures::kCycleMs, 50)) send(motor_);
  const std::int32_t cycle = can::cell_cycle_ms(cell_.size());
  for (std::size_t group = 0; group * can::CellVoltages::kPerFrame < cell_.size(); ++group) {
    if (can::due(now_ms, cycle, static_cast<std::int32_t>(10 * group))) send(cells(group));
  }
  for (std::size_t group = 0; group * can::Temperatures::kPerFrame < temperature_dc_.size(); ++group) {
    if (can::due(now_ms, can::Temperatures::kCycleMs, static_cast<std::int32_t>(10 * group))) send(temperatures(group));
  }
}

}  // namespace same_firmware
