// SPDX-License-Identifier: Apache-2.0
#include "car.hpp"

#include <algorithm>
#include <cmath>

namespace same_firmware {
namespace {

constexpr double kMotorConstant = 0.15;        // Nm/A and V s/rad
constexpr double kRadPerSPerRpm = 0.1047198;
constexpr std::int32_t kBrakePressed = 20'000;  // mbar

std::int32_t whole(double value) { return static_cast<std::int32_t>(std::lround(std::clamp(value, -2e9, 2e9))); }

}  // namespace

void Heard::read(const voltlap::Frame& frame) {
  static_cast<void>(decode(frame, contactors) || decode(frame, inverter) || decode(frame, limits) ||
                    decode(frame, bms) || decode(frame, master));
}

Car::Car(const Settings& settings, Draw& draw) : settings_(settings.bms), draw_(draw) {
  soc_ = draw.chance(0.2) ? 0.1 * draw.share() : draw.chance(0.2) ? 0.9 + 0.1 * draw.share() : draw.share();
  soc_per_amp_tick_ = draw.chance(0.5) ? 0.0 : 1e-6 * draw.share();
  resistance_ = 1e-6 * draw.between(500, 5'000);
  motor_heat_ = draw.chance(0.6) ? 0.0 : 1e-6 * draw.share();
  pack_heat_ = draw.chance(0.6) ? 0.0 : 1e-6 * draw.share();
  excess_ = 0.7 + 0.6 * draw.share();
  pack_c_ = draw.chance(0.1) ? draw.between(-5, 55) : 25.0;
  link_ticks_ = draw.between(2, 60);
  contact_ticks_ = draw.between(0, 4);
  const auto cells = static_cast<std::size_t>(settings_.cells_in_series);
  cell_.resize(cells);
  cell_ok_.resize(cells);
  cell_offset_.resize(cells);
  for (std::int32_t& offset : cell_offset_) offset = draw.between(-200, 200);
  temperature_dc_.resize(static_cast<std::size_t>(std::max(settings_.temperature_sensors, 0)));
  temperature_ok_.resize(temperature_dc_.size());
  if (draw.chance(0.2)) plant_trouble();
}

void Car::plant_trouble() {
  troubles_.push_back({static_cast<Trouble>(draw_.below(kTroubles)), draw_.between(0, 200), draw_.between(0, 1000),
                       draw_.duration(draw_.chance(0.2) ? 2'000 : 200)});
}

void Car::step(const Heard& heard) {
  drive(heard);
  press_buttons(heard);
  move_contactors(heard);
  move_motor(heard);
  heat();
  set_cells();
  inverter_sends_ = true;
  for (Active& trouble : troubles_) {
    suffer(trouble);
    suffer_in_pack(trouble);
    --trouble.ticks_left;
  }
  std::erase_if(troubles_, [](const Active& trouble) { return trouble.ticks_left <= 0; });
}

// Feet change what they do every now and then: mostly what the state of the car asks for.
void Car::drive(const Heard& heard) {
  pedals_.apps1_ok = pedals_.apps2_ok = pedals_.brake_front_ok = pedals_.brake_rear_ok = true;
  if (--foot_ticks_ <= 0) {
    foot_ticks_ = draw_.duration(200);
    const bool ready = heard.master.drive_state == can::DriveState::kReadyToDrive;
    const bool braking = ready ? draw_.chance(0.3) : draw_.chance(0.8);
    const std::int32_t share[] = {0, 49, 50, 51, 249, 250, 251, 1000, draw_.between(0, 1000), draw_.between(0, 1000)};
    pedal_permille_ = braking || (!ready && draw_.chance(0.95)) ? 0 : draw_.of(share);
    const std::int32_t pressure[] = {kBrakePressed, kBrakePressed, draw_.between(2'950, 3'050),
                                     draw_.between(0, 45'000)};
    brake_mbar_ = braking ? draw_.of(pressure) : 0;
  }
  pedals_.apps1_100uv = 5'000 + 40 * pedal_permille_ + draw_.between(-20, 20);
  pedals_.apps2_100uv = 2'500 + 20 * pedal_permille_ + draw_.between(-20, 20);
  pedals_.brake_front_mbar = brake_mbar_;
  pedals_.brake_rear_mbar = brake_mbar_ - brake_mbar_ / 8;
}

// The button that leads on from the state of the car, down for a while and up for a while.
void Car::press_buttons(const Heard& heard) {
  io_.shutdown_closed = true;
  if (--button_ticks_ <= 0) {
    button_down_ = !button_down_;
    button_ticks_ = button_down_ ? draw_.between(2, 20) : draw_.between(5, 80);
  }
  const can::DriveState mode = heard.master.drive_state;
  const bool fault = mode == can::DriveState::kFault || heard.bms.faults != 0;
  io_.reset_button = button_down_ && fault;
  io_.ts_on_button = button_down_ && mode == can::DriveState::kLvOn && !fault;
  io_.rtd_button = button_down_ && mode == can::DriveState::kTsActive;
}

// Contacts follow their command after a time; the DC link charges through the resistor and discharges slowly.
void Car::move_contactors(const Heard& heard) {
  const std::array<bool, 3> command{heard.contactors.air_plus_close, heard.contactors.air_minus_close,
                                    heard.contactors.precharge_close};
  for (std::size_t i = 0; i < 3; ++i) {
    if (closed_[i] == command[i]) {
      contact_ticks_left_[i] = contact_ticks_;
    } else if (--contact_ticks_left_[i] <= 0) {
      closed_[i] = command[i];
    }
  }
  io_.air_plus_aux = closed_[0];
  io_.air_minus_aux = closed_[1];
  io_.precharge_aux = closed_[2];
  const std::int32_t full = pack_.pack_voltage_100uv;
  std::int32_t& link = inverter_.dc_link_voltage_100uv;
  const bool connected = closed_[1] && (closed_[0] || closed_[2]);
  link = closed_[0] && closed_[1] ? full
         : connected              ? std::min(full, link + full / link_ticks_)
                                  : std::max(0, link - full / 200);
}

void Car::move_motor(const Heard& heard) {
  const bool on = inverter_.dc_link_voltage_100uv > 300'000;
  inverter_.state = !on                     ? can::InverterState::kOff
                    : heard.inverter.enable ? can::InverterState::kEnabled
                                            : can::InverterState::kDisabled;
  const double phase_a = on && heard.inverter.enable ? 1e-3 * heard.inverter.phase_current_ma : 0.0;
  speed_rpm_ += 0.08 * phase_a - 0.002 * speed_rpm_ - 0.001 * brake_mbar_;
  speed_rpm_ = std::clamp(speed_rpm_, 0.0, 12'000.0);
  inverter_.motor_speed_rpm = whole(speed_rpm_);
  inverter_.phase_current_ma = whole(1e3 * phase_a);
  inverter_.motor_speed_ok = inverter_.dc_link_voltage_ok = inverter_.phase_current_ok = true;
  const double voltage = std::max(1.0, 1e-4 * pack_.pack_voltage_100uv);
  const double pack_a = excess_ * kMotorConstant * speed_rpm_ * kRadPerSPerRpm * phase_a / voltage;
  pack_.pack_current_ma = whole(1e3 * pack_a) + draw_.between(-50, 50);
  pack_.pack_current_ok = pack_.pack_voltage_ok = true;
  constexpr double kMmPerSPerRpm = 2.3;
  const std::int32_t wheel = whole(kMmPerSPerRpm * speed_rpm_);
  wheels_.front_left_mmps = wheels_.front_right_mmps = wheels_.rear_left_mmps = wheels_.rear_right_mmps = wheel;
  wheels_.front_left_ok = wheels_.front_right_ok = wheels_.rear_left_ok = wheels_.rear_right_ok = true;
  soc_ = std::clamp(soc_ - soc_per_amp_tick_ * pack_a, 0.0, 1.0);
}

void Car::heat() {
  const double phase_a = 1e-3 * inverter_.phase_current_ma, pack_a = 1e-3 * pack_.pack_current_ma;
  motor_c_ += motor_heat_ * phase_a * phase_a - 1e-3 * (motor_c_ - 40.0);
  pack_c_ += pack_heat_ * pack_a * pack_a - 1e-4 * (pack_c_ - 25.0);
  motor_.motor_dc = whole(10.0 * motor_c_);
  motor_.inverter_dc = whole(10.0 * std::min(motor_c_, 90.0));
  motor_.motor_ok = motor_.inverter_ok = true;
  for (std::size_t i = 0; i < temperature_dc_.size(); ++i) {
    temperature_dc_[i] = whole(10.0 * pack_c_) + static_cast<std::int32_t>(i % 4);
    temperature_ok_[i] = true;
  }
}

void Car::set_cells() {
  const double low = soc_ < 0.5 ? settings_.ocv_empty : settings_.ocv_middle;
  const double high = soc_ < 0.5 ? settings_.ocv_middle : settings_.ocv_full;
  const double open = low + (high - low) * (soc_ < 0.5 ? 2.0 * soc_ : 2.0 * soc_ - 1.0);
  const std::int32_t loaded = whole(open - 1e4 * resistance_ * 1e-3 * pack_.pack_current_ma);
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    cell_[i] = std::clamp(loaded + cell_offset_[i], 20'000, 45'000);
    cell_ok_[i] = true;
    sum += cell_[i];
  }
  pack_.pack_voltage_100uv = sum;
}

void Car::suffer(const Active& t) {
  switch (t.kind) {
    case Trouble::kShutdownOpen: io_.shutdown_closed = false; break;
    case Trouble::kContactWelded:
    case Trouble::kContactOpen: {
      bool* const contact[] = {&io_.air_plus_aux, &io_.air_minus_aux, &io_.precharge_aux};
      *contact[t.index % 3] = t.kind == Trouble::kContactWelded;
      break;
    }
    case Trouble::kLinkHigh: inverter_.dc_link_voltage_100uv = pack_.pack_voltage_100uv; break;
    case Trouble::kLinkLow: inverter_.dc_link_voltage_100uv = pack_.pack_voltage_100uv / 1000 * t.size; break;
    case Trouble::kAppsOffset: pedals_.apps1_100uv += 5 * t.size; break;
    case Trouble::kAppsRange: {
      constexpr std::int32_t kEnds1[] = {3'000, 47'000}, kEnds2[] = {1'500, 23'500};
      const std::int32_t off = t.size % 2 == 0 ? 10 * (t.size % 9 - 4) : 10 * (t.size - 500);
      if (t.index % 2 == 0) pedals_.apps1_100uv = kEnds1[t.index / 2 % 2] + off;
      if (t.index % 2 == 1) pedals_.apps2_100uv = kEnds2[t.index / 2 % 2] + off;
      break;
    }
    case Trouble::kBothPedals:
      pedals_.apps1_100uv = 5'000 + 40 * t.size;
      pedals_.apps2_100uv = 2'500 + 20 * t.size;
      pedals_.brake_front_mbar = pedals_.brake_rear_mbar = kBrakePressed;
      break;
    case Trouble::kBrakeInvalid: (t.index % 2 == 0 ? pedals_.brake_front_ok : pedals_.brake_rear_ok) = false; break;
    case Trouble::kWheelsInvalid:
      wheels_.front_left_ok = wheels_.front_right_ok = false;
      wheels_.rear_left_ok = t.index % 2 == 0;
      break;
    case Trouble::kInverterFault: inverter_.state = static_cast<can::InverterState>(t.index % 16); break;
    case Trouble::kInverterSilent: inverter_sends_ = false; break;
    case Trouble::kMotorHot: motor_.motor_dc = 1'300 + t.size / 3; break;
    case Trouble::kInverterHot: motor_.inverter_dc = 700 + t.size / 3; break;
    case Trouble::kNoSpeed: inverter_.motor_speed_ok = false; break;
    case Trouble::kReverse: inverter_.motor_speed_rpm = -t.size; break;
    case Trouble::kButtonsStuck: io_.ts_on_button = io_.rtd_button = io_.reset_button = t.index % 2 == 0; break;
    default: break;
  }
}

// A trouble of the pack stands a few steps of the wire on either side of what it is judged by.
void Car::suffer_in_pack(const Active& t) {
  const auto cell = static_cast<std::size_t>(t.index) % cell_.size();
  const bool sensors = !temperature_dc_.empty();
  const auto sensor = sensors ? static_cast<std::size_t>(t.index) % temperature_dc_.size() : 0;
  const std::int32_t step = t.size % 7 - 3;
  switch (t.kind) {
    case Trouble::kCellLow: cell_[cell] = (t.size < 500 ? 24'000 : 25'000) + step; break;
    case Trouble::kCellHigh: cell_[cell] = (t.size < 500 ? 42'500 : 42'000) + step; break;
    case Trouble::kCellInvalid: cell_ok_[cell] = false; break;
    case Trouble::kPackAtLimit:
      if (sensors) temperature_dc_[sensor] = t.size < 250 ? 600 + step : t.size < 500 ? step : 540 + t.size / 15;
      break;
    case Trouble::kThermistorInvalid:
      if (sensors) temperature_ok_[sensor] = false;
      break;
    case Trouble::kCurrentAtLimit:
      pack_.pack_current_ma = step + std::array{settings_.discharge_current_trip, -settings_.charge_current_trip, 1'000,
                                                -1'000}[static_cast<std::size_t>(t.index % 4)];
      break;
    case Trouble::kCurrentInvalid: pack_.pack_current_ok = false; break;
    case Trouble::kVoltageOff: pack_.pack_voltage_100uv += pack_.pack_voltage_100uv / 10'000 * (t.size - 500); break;
    default: break;
  }
}

can::CellVoltages Car::cells(std::size_t group) const {
  can::CellVoltages m;
  m.group = static_cast<std::uint8_t>(group);
  for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
    const std::size_t cell = group * can::CellVoltages::kPerFrame + i;
    m.cell_ok[i] = cell < cell_.size() && cell_ok_[cell];
    if (m.cell_ok[i]) m.cell_100uv[i] = cell_[cell];
  }
  return m;
}

can::Temperatures Car::temperatures(std::size_t group) const {
  can::Temperatures m;
  m.group = static_cast<std::uint8_t>(group);
  for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i) {
    const std::size_t sensor = group * can::Temperatures::kPerFrame + i;
    m.temperature_ok[i] = sensor < temperature_dc_.size() && temperature_ok_[sensor];
    if (m.temperature_ok[i]) m.temperature_dc[i] = temperature_dc_[sensor];
  }
  return m;
}

}  // namespace same_firmware
