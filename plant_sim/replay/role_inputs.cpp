// SPDX-License-Identifier: Apache-2.0
#include "replay/role_inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "replay/bus_as_pack.hpp"
#include "replay/repeated_readings.hpp"

namespace voltlap::plant {
namespace {

constexpr double kMildest_c = 25.0;      // where nothing is measured
constexpr double kWaitForRest_s = 10.0;  // the SOC starts from cells at rest; so long is waited for them
constexpr double kRelaxed_s = 60.0;      // chosen: most of a cell's slow branch
constexpr double kShortestRest_s = 5.0;  // chosen, after a load: a cell's fast branch
constexpr double kMovesMost_v = 1.0;     // chosen: more is no sag and no rise of a cell
constexpr double kClearSign = 0.2;       // of sign_evidence, as where the sign of the current is found
constexpr double kStep_s = 1e-3 * can::kTickMs;

std::string seconds(double value) {
  return value < 1.0 ? fmt::format("{:.0f} ms", 1e3 * value) : fmt::format("{:.3g} s", value);
}

/// How much a cell moves with its share of the pack's voltage: least squares over its samples, drawn towards 1 where
/// they say little.
double share_of_pack(const Channel& cell, const Channel& pack, double cells) {
  constexpr double kPrior = 3.0 * 0.05 * 0.05;  // V^2: three samples 50 mV from the mean; chosen
  double count = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t k = 0; k < cell.size(); ++k) {
    const double own = cell.value[k], mean = value_at(pack, cell.time_s[k]) / cells;
    if (!std::isfinite(own) || !std::isfinite(mean)) continue;
    count += 1.0;
    x += mean;
    y += own;
    xx += mean * mean;
    xy += mean * own;
  }
  if (count < 2.0) return 1.0;
  return std::clamp((xy - x * y / count + kPrior) / (xx - x * x / count + kPrior), 0.5, 3.0);
}

/// Squares of what a carried cell is off by when its next reading comes, and their number.
std::pair<double, double> carried_errors(const Channel& cell, const Channel& pack, double share_by_cells) {
  double sum = 0.0, count = 0.0, last_v = kUnknown, last_pack_v = kUnknown;
  for (std::size_t k = 0; k < cell.size(); ++k) {
    const double pack_v = value_at(pack, cell.time_s[k]);
    if (!std::isfinite(cell.value[k]) || !std::isfinite(pack_v)) continue;
    const double off = last_v + share_by_cells * (pack_v - last_pack_v) - cell.value[k];
    if (std::isfinite(off)) {
      sum += off * off;
      count += 1.0;
    }
    last_v = cell.value[k];
    last_pack_v = pack_v;
  }
  return {sum, count};
}

}  // namespace

std::size_t recorded_cells(const DriveLog& log) {
  const auto cells = log.numbered("cell_voltage_");
  return cells.empty() ? (log.find("voltage") != nullptr ? 1U : 0U) : static_cast<std::size_t>(cells.back().first);
}

std::size_t recorded_thermistors(const DriveLog& log) { return log.numbered("temperature_").size(); }

RoleInputs::RoleInputs(const DriveLog& log, const ReplayCar& car) : car_(car) {
  VOLTLAP_DEMAND(car.cells > 0 && car.thermistors > 0);
  take_battery(log);
  take_temperatures(log);
  take_motion(log);
  find_begin();
  assumptions_.insert(assumptions_.begin(),
                      "contactors, precharge, DC link, shutdown circuit and buttons are ideal and follow the firmware: "
                      "what the car's own did is not judged");
}

/// The time-out of the message that carries them, or some of their usual intervals where the recording is slower.
double RoleInputs::longest_s(const std::vector<const Channel*>& channels, std::int32_t timeout_ms) const {
  return std::max(1e-3 * timeout_ms, car_.hold_intervals * usual_interval_s(channels));
}

HeldChannel RoleInputs::channel(const DriveLog& log, const std::string& role, std::int32_t timeout_ms) const {
  const Channel* recorded = log.find(role);
  return recorded == nullptr ? HeldChannel() : HeldChannel(recorded, longest_s({recorded}, timeout_ms));
}

void RoleInputs::take_battery(const DriveLog& log) {
  current_ = channel(log, "current", can::PackSensor::kTimeoutMs);
  if (!current_.recorded()) {
    throw InputError(log.path, "no current", "the role current", "The firmware has nothing to replay without it");
  }
  choose_pack_voltage(log);
  take_cells(log);
  if (!pack_.recorded()) assume("no pack voltage: the sum of the cells");
}

/// A published voltage that rises with the discharge current is no measurement; then the bus is one, while it is
/// connected.
void RoleInputs::choose_pack_voltage(const DriveLog& log) {
  const Channel *own = log.find("pack_voltage"), *bus = log.find("bus_voltage"), *current = log.find("current");
  const bool rises = own != nullptr && sign_evidence(*current, *own) > kClearSign;
  const bool bus_falls = bus != nullptr && sign_evidence(*current, *bus) < -kClearSign;
  if (own != nullptr && !(rises && bus_falls)) {
    pack_ = channel(log, "pack_voltage", can::PackSensor::kTimeoutMs);
    pack_channel_ = own;
  } else if (bus != nullptr) {
    bus_ = pack_by_bus(*bus, own);
    pack_channel_ = &bus_;
    pack_ = HeldChannel(&bus_, longest_s({&bus_}, can::PackSensor::kTimeoutMs));
    assume(fmt::format("the pack's voltage is that of the bus while it is connected: {}",
                       rises ? "the published one rises with the discharge current" : "no other is recorded"));
  }
}

void RoleInputs::take_cells(const DriveLog& log) {
  cells_.resize(car_.cells);
  std::vector<std::pair<int, const Channel*>> numbered = log.numbered("cell_voltage_");
  if (numbered.empty() && log.find("voltage") != nullptr) numbered = {{1, log.find("voltage")}};
  shared_pack_ = numbered.empty();
  if (shared_pack_) {
    assume(fmt::format("no cell voltages: each of the {} cells has its share of the pack's", car_.cells));
    if (pack_.recorded()) return;
    throw InputError(log.path, "no voltage of a cell or of the pack", "cell_voltage_<n>, pack_voltage or bus_voltage",
                     "Name them in the map");
  }
  take_once(log, numbered);
  std::vector<const Channel*> all;
  for (const auto& [n, recorded] : numbered) all.push_back(recorded);
  const double usual_s = usual_interval_s(all), held_s = longest_s(all, can::CellVoltages::kTimeoutMs);
  for (const auto& [n, recorded] : numbered) {
    const auto index = static_cast<std::size_t>(n) - 1;
    if (index < cells_.size()) cells_[index].voltage = HeldChannel(recorded, held_s);
  }
  if (const std::size_t missing = cells_.size() - std::min(cells_.size(), all.size()); missing > 0) {
    if (!pack_.recorded()) {
      throw InputError(log.path, fmt::format("no reading of {} of {} cells", missing, car_.cells),
                       "every cell, or the pack's voltage", "Name them in the map, or the cells that there are");
    }
    assume(fmt::format("{} of {} cells have no reading: their share of the pack's", missing, car_.cells));
  }
  if (usual_s <= 1e-3 * can::CellVoltages::kTimeoutMs) return;
  carries_ = car_.carry_cells && pack_.recorded() && pack_.longest_s() < held_s;
  assume(fmt::format("a cell is read every {}, slower than the firmware's time-out of {} ms: {} for up to {}",
                     seconds(usual_s), can::CellVoltages::kTimeoutMs,
                     carries_ ? "between readings it moves with the pack's voltage, by as much as its readings do,"
                              : "its last reading is held",
                     seconds(held_s)));
  if (carries_) learn_shares(numbered);
}

/// Each reading of a slow cell once, where the logger writes it again in every row.
void RoleInputs::take_once(const DriveLog& log, std::vector<std::pair<int, const Channel*>>& numbered) {
  const Channel& live = pack_channel_ != nullptr ? *pack_channel_ : *log.find("current");
  once_.reserve(numbered.size());
  for (auto& [n, recorded] : numbered) {
    auto once = without_repeats(*recorded, live);
    if (!once) continue;
    once_.push_back(std::move(*once));
    recorded = &once_.back();
  }
  if (once_.empty()) return;
  assume(fmt::format("{} of {} cells change in every {} only, and stand the same in the rows between: each reading is "
                     "taken once",
                     once_.size(), numbered.size(), seconds(usual_interval_s({&once_.front()}))));
}

void RoleInputs::learn_shares(const std::vector<std::pair<int, const Channel*>>& numbered) {
  const auto cells = static_cast<double>(car_.cells);
  double squares = 0.0, readings = 0.0;
  for (const auto& [n, recorded] : numbered) {
    const auto index = static_cast<std::size_t>(n) - 1;
    if (index >= cells_.size()) continue;
    cells_[index].share = share_of_pack(*recorded, *pack_channel_, cells);
    const auto [sum, count] = carried_errors(*recorded, *pack_channel_, cells_[index].share / cells);
    squares += sum;
    readings += count;
  }
  if (readings > 0.0) {
    assumptions_.back() += fmt::format("; when the next one comes it is off by {:.0f} mV (rms)",
                                       1e3 * std::sqrt(squares / readings));
  }
}

void RoleInputs::take_temperatures(const DriveLog& log) {
  const auto numbered = log.numbered("temperature_");
  std::vector<const Channel*> all;
  for (const auto& [n, recorded] : numbered) all.push_back(recorded);
  const std::size_t used = std::min(all.size(), car_.thermistors);
  const double held_s = longest_s(all, can::Temperatures::kTimeoutMs);
  for (std::size_t k = 0; k < used; ++k) temperatures_.emplace_back(all[k * all.size() / used], held_s);
  if (temperatures_.empty()) {
    assume(fmt::format("no temperature: {:.0f} degC throughout", kMildest_c));
  } else if (all.size() < car_.thermistors) {
    assume(fmt::format("{} thermistors for {} that the firmware asks for: they stand for the others in turn", used,
                       car_.thermistors));
  } else if (used < all.size()) {
    assume(fmt::format("{} of {} thermistors, evenly: the bus carries no more", used, all.size()));
  }
}

void RoleInputs::take_motion(const DriveLog& log) {
  motor_speed_ = channel(log, "motor_speed", can::InverterStatus::kTimeoutMs);
  motor_torque_ = channel(log, "motor_torque", can::InverterStatus::kTimeoutMs);
  motor_current_ = channel(log, "motor_current", can::InverterStatus::kTimeoutMs);
  accelerator_ = channel(log, "accelerator", can::Pedals::kTimeoutMs);
  brake_ = channel(log, "brake", can::Pedals::kTimeoutMs);
  brake_pressure_ = channel(log, "brake_pressure", can::Pedals::kTimeoutMs);
  for (int n = 1; n <= 4; ++n) {
    const std::string role = fmt::format("wheel_speed_{}", n);
    wheels_.push_back(channel(log, log.find(role) != nullptr ? role : "speed", can::WheelSpeeds::kTimeoutMs));
  }
  soc_ = channel(log, "soc", 1000);
  discharge_limit_ = channel(log, "discharge_limit", 1000);
  charge_limit_ = channel(log, "charge_limit", 1000);
  if (!motor_speed_.recorded() || (!motor_torque_.recorded() && !motor_current_.recorded())) {
    assume("no motor speed with torque or current: the battery's current is not held against the motor's power");
  }
  if (!accelerator_.recorded()) assume("no accelerator: released");
  if (!brake_.recorded() && !brake_pressure_.recorded()) assume("no brake: released");
}

void RoleInputs::find_begin() {
  begin_s_ = current_.first_s();
  end_s_ = current_.last_s();
  for (const Cell& cell : cells_) {
    if (cell.voltage.recorded()) begin_s_ = std::max(begin_s_, cell.voltage.first_s());
  }
  for (const HeldChannel& one : temperatures_) begin_s_ = std::max(begin_s_, one.first_s());
  if (pack_.recorded()) begin_s_ = std::max(begin_s_, pack_.first_s());
  find_end();
  begin_s_ = kStep_s * std::ceil(begin_s_ / kStep_s - 1e-9);
  find_rest();
}

/// Recordings go on after the car is switched off: the bus falls, or is silent, and no current flows.
void RoleInputs::find_end() {
  constexpr double kOff = 0.5, kPatience_s = 0.5;  // of the usual voltage; what the BMS waits for a reading
  if (pack_channel_ == nullptr || pack_channel_->size() == 0) return;
  std::vector<double> values;
  for (const double value : pack_channel_->value) {
    if (std::isfinite(value)) values.push_back(value);
  }
  const double usual_v = median(std::move(values));
  std::size_t on = pack_channel_->size();
  while (on > 0 && !(pack_channel_->value[on - 1] > kOff * usual_v)) --on;
  const double off_s = on > 0 ? pack_channel_->time_s[on - 1] : begin_s_;
  if (off_s <= begin_s_ || off_s + std::max(kPatience_s, pack_.longest_s()) >= end_s_) return;
  HeldChannel current = current_;
  for (double t = off_s; t <= end_s_; t += kStep_s) {
    current.advance(t);
    if (t > off_s + kPatience_s && current.known() && std::abs(current.value()) > car_.rest_current_a) return;
  }
  assume(fmt::format("from {:.1f} s to its end at {:.1f} s the log has no pack voltage and no current: high voltage is "
                     "off there, and nothing is replayed",
                     off_s, end_s_));
  end_s_ = off_s;
}

/// The SOC starts from the cells' voltage: from rest where there is one. A sample without current between two of load
/// is none; what the recording begins with may be the end of a long one.
void RoleInputs::find_rest() {
  HeldChannel current = current_;
  double rest_since_s = kUnknown;
  bool loaded = false;
  for (double t = current.first_s(); t <= std::min(end_s_, begin_s_ + kWaitForRest_s); t += kStep_s) {
    current.advance(t);
    const bool rest = current.known() && std::abs(current.value()) <= car_.rest_current_a;
    loaded = loaded || (current.known() && !rest);
    if (!rest) rest_since_s = kUnknown;
    if (rest && !std::isfinite(rest_since_s)) rest_since_s = t;
    if (!rest || t < begin_s_ - 1e-9 || (loaded && t - rest_since_s < kShortestRest_s) || !is_settled(t)) continue;
    if (t - rest_since_s < kRelaxed_s) {
      assume(fmt::format("the SOC starts from cells after {:.1f} s without current, less than they need to relax",
                         t - rest_since_s));
    }
    begin_s_ = kStep_s * std::ceil(t / kStep_s - 1e-9);
    return;
  }
  begins_under_load_ = true;
}

/// Not while the voltage still comes up: filters of loggers and of battery units begin at nothing.
bool RoleInputs::is_settled(double time_s) const {
  constexpr double kWithin_s = 1.0, kShare = 0.005;  // chosen: 20 mV of a cell; relaxation is slower
  if (pack_channel_ == nullptr) return true;
  const double now = value_at(*pack_channel_, time_s), next = value_at(*pack_channel_, time_s + kWithin_s);
  return !(std::abs(next - now) > kShare * std::abs(next));
}

void RoleInputs::advance(double time_s) {
  now_s_ = time_s;
  for (HeldChannel* one : {&current_, &pack_, &motor_speed_, &motor_torque_, &motor_current_, &accelerator_, &brake_,
                           &brake_pressure_, &soc_, &discharge_limit_, &charge_limit_}) {
    one->advance(time_s);
  }
  for (HeldChannel& wheel : wheels_) wheel.advance(time_s);
  if (carries_ && time_s >= next_levelling_s_) level_cells();
}

/// Carried cells add up to the pack: what is left over is spread over all of them.
void RoleInputs::level_cells() {
  constexpr double kEvery_s = 0.1;
  next_levelling_s_ = now_s_ + kEvery_s;
  levelling_v_ = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < car_.cells; ++i) sum += cell(i);
  const double left_v = (pack_v() - sum) / static_cast<double>(car_.cells);
  if (std::abs(left_v) < kMovesMost_v) levelling_v_ = left_v;
}

double RoleInputs::pack_v() {
  return std::isfinite(alike_v_) ? alike_v_ * static_cast<double>(car_.cells) : recorded_pack_v();
}

double RoleInputs::cell(std::size_t index) {
  return std::isfinite(alike_v_) ? alike_v_ : recorded_cell(index);
}

double RoleInputs::recorded_pack_v() {
  if (pack_.recorded()) return pack_.known() ? pack_.value() : kUnknown;
  double sum = 0.0;
  for (std::size_t i = 0; i < car_.cells; ++i) sum += recorded_cell(i);
  return sum;
}

double RoleInputs::recorded_cell(std::size_t index) {
  if (shared_pack_) return recorded_pack_v() / static_cast<double>(car_.cells);
  Cell& cell = cells_[index];
  cell.voltage.advance(now_s_);
  if (!cell.voltage.recorded()) return recorded_pack_v() / static_cast<double>(car_.cells);
  if (!cell.voltage.known()) return kUnknown;
  if (!carries_) return cell.voltage.value();
  if (cell.voltage.sampled_s() > cell.taken_s) {
    cell.taken_s = cell.voltage.sampled_s();
    cell.pack_then_v = value_at(*pack_channel_, cell.taken_s);
  }
  const double moved_v = cell.share * (recorded_pack_v() - cell.pack_then_v) / static_cast<double>(car_.cells);
  // Contactors that open under load throw the bus up; no cell follows it.
  return cell.voltage.value() + (std::abs(moved_v) < kMovesMost_v ? moved_v + levelling_v_ : 0.0);
}

double RoleInputs::thermistor(std::size_t index) {
  if (temperatures_.empty()) return kMildest_c;
  HeldChannel& one = temperatures_[index % temperatures_.size()];
  one.advance(now_s_);
  return one.known() ? one.value() : kUnknown;
}

Readings RoleInputs::readings() {
  Readings out;
  out.current_a = current_a();
  out.pack_v = pack_v();
  if (motor_speed_.known()) out.motor_speed_rpm = motor_speed_.value();
  if (motor_current_.known()) {
    out.phase_current_a = motor_current_.value();
  } else if (motor_torque_.known() && car_.motor_constant_nm_per_a > 0.0) {
    out.phase_current_a = motor_torque_.value() / car_.motor_constant_nm_per_a;
  }
  if (accelerator_.known()) out.accelerator = accelerator_.value();
  if (brake_.known()) out.brake_bar = brake_.value() * car_.full_brake_bar;
  if (brake_pressure_.known()) out.brake_bar = brake_pressure_.value();
  for (std::size_t n = 0; n < 4; ++n) {
    if (wheels_[n].known()) out.wheel_mps[n] = wheels_[n].value();
  }
  return out;
}

LoggedMoment RoleInputs::moment() {
  LoggedMoment out;
  out.current_a = current_a();
  if (soc_.known()) out.soc = soc_.value();
  if (discharge_limit_.known()) out.discharge_limit_a = discharge_limit_.value();
  if (charge_limit_.known()) out.charge_limit_a = charge_limit_.value();
  for (std::size_t i = 0; i < car_.cells; ++i) {
    const double volts = cell(i);
    out.cell_min_v = std::fmin(out.cell_min_v, volts);
    out.cell_max_v = std::fmax(out.cell_max_v, volts);
  }
  for (std::size_t i = 0; i < temperatures_.size(); ++i) {
    out.temperature_max_c = std::fmax(out.temperature_max_c, thermistor(i));
  }
  return out;
}

}  // namespace voltlap::plant
