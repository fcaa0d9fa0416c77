// SPDX-License-Identifier: Apache-2.0
#include "race/actuators/command_receiver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace voltlap::plant {
namespace {

constexpr std::size_t kCellsPerWord = 24;  // of BalancingCommand in car.dbc

}  // namespace

void CommandReceiver::receive(Instant now, FrameView frames, Car& car) {
  for (const Frame& frame : frames) {
    if (monitor_.receive(frame, now) != codec::RxVerdict::kAccepted) continue;
    can::InverterCommand inverter;
    can::BalancingCommand balancing;
    can::ChargerCommand charger;
    can::Pm100Command torque;
    codec::AmkSetpoints setpoints;
    std::size_t wheel = 0;
    if (decode(frame, contactors_)) {
      car.contactors.air_plus.command(contactors_.air_plus_close);
      car.contactors.air_minus.command(contactors_.air_minus_close);
      car.contactors.precharge.command(contactors_.precharge_close);
    } else if (decode(frame, torque)) {
      take_pm100(torque, car);
    } else if (codec::decode_amk(frame, wheel, setpoints)) {
      if (car.has_amk()) take_amk(setpoints, car.drives[wheel]);
    } else if (decode(frame, inverter)) {
      const bool enable = inverter.enable && inverter.phase_current_ok;
      if (!car.has_pm100() && !car.has_amk()) car.inverter.command(inverter.phase_current_ma * 1e-3, enable);
    } else if (decode(frame, balancing)) {
      take_balancing(balancing, car);
    } else if (decode(frame, charger)) {
      car.charger.command(charger.voltage_max_100uv * 1e-4, charger.current_max_ma * 1e-3,
                          charger.control == can::ChargerControl::kCharge);
    } else if (!decode(frame, charge_) && !decode(frame, limits_) && !decode(frame, bms_)) {
      static_cast<void>(decode(frame, master_));
    }
  }
  if (car.has_pm100()) drive_by_pm100(car);
  if (car.has_amk()) drive_by_amk(car);
  monitor_.expire(now);
  forget_unless_fresh(now, limits_);
  forget_unless_fresh(now, bms_);
  forget_unless_fresh(now, master_);
  forget_unless_fresh(now, charge_);
  end_silent_balancing(now, car);
  if (!monitor_.fresh(can::ContactorCommand::kId, now)) {
    for (Contactor* c : {&car.contactors.air_plus, &car.contactors.air_minus, &car.contactors.precharge})
      c->command(false);
  }
}

void CommandReceiver::take_pm100(const can::Pm100Command& m, Car& car) {
  const Pm100::Command command{m.torque_mnm * 1e-3, m.torque_limit_mnm * 1e-3, m.forward, m.enable, m.speed_mode,
                               m.rolling_counter};
  if (m.torque_ok && m.torque_limit_ok) (void)car.pm100.receive(command);
}

// Its current controller is the one of any inverter, the torque a current by the motor's constant: it goes on with what
// was asked until the PM100 stops, by its own time-out too.
void CommandReceiver::drive_by_pm100(Car& car) {
  car.inverter.command(car.pm100.torque_nm() / car.parameters().motor.constant_nm_per_a, car.pm100.enabled());
}

void CommandReceiver::take_amk(const codec::AmkSetpoints& m, MotorDrive& drive) {
  const double nominal_nm_per_ppm = 1e-6 * drive.amk.nominal_torque_nm();
  Amk::Setpoints s;
  s.inverter_on = m.inverter_on;
  s.dc_on = m.dc_on;
  s.enable = m.enable;
  s.error_reset = m.error_reset;
  s.speed_rpm = m.target_velocity_rpm;
  s.torque_positive_nm = m.torque_limit_positive_ppm * nominal_nm_per_ppm;
  s.torque_negative_nm = m.torque_limit_negative_ppm * nominal_nm_per_ppm;
  drive.amk.receive(s);
}

// As with a PM100: the current controller goes on with what its logic allows.
void CommandReceiver::drive_by_amk(Car& car) {
  for (MotorDrive& drive : car.drives) {
    const double torque_nm = drive.amk.torque_nm(car.motor_omega_rad_s(drive) * 30.0 / M_PI);
    drive.inverter.command(torque_nm / car.parameters().motor.constant_nm_per_a, drive.amk.inverter_on());
  }
}

void CommandReceiver::take_balancing(const can::BalancingCommand& m, Car& car) {
  bool changed = false;
  for (std::size_t k = 0; k < can::BalancingCommand::kPerFrame; ++k) {
    std::uint32_t& word = bled_[m.group * can::BalancingCommand::kPerFrame + k];
    changed = changed || word != m.cells[k];
    word = m.cells[k];
  }
  if (changed) move_shunts(car);
}

void CommandReceiver::end_silent_balancing(Instant now, Car& car) {
  if (std::all_of(bled_.begin(), bled_.end(), [](std::uint32_t word) { return word == 0; })) return;
  for (std::uint8_t group = 0; group < can::BalancingCommand::kGroups; ++group) {
    if (!monitor_.fresh(can::BalancingCommand::kBaseId + group, now)) take_balancing({.group = group}, car);
  }
}

void CommandReceiver::move_shunts(Car& car) const {
  std::vector<std::size_t> cells;
  for (std::size_t i = 0; i < car.pack().cells(); ++i) {
    if ((bled_[i / kCellsPerWord] >> (i % kCellsPerWord) & 1U) != 0) cells.push_back(i);
  }
  car.pack().set_bleeding(std::move(cells));
}

}  // namespace voltlap::plant
