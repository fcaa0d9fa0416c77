// SPDX-License-Identifier: Apache-2.0
#include "replay/firmware_watch.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace voltlap::plant {
namespace {

constexpr double kRow_s = 0.1;       // of the time series; the firmware steps ten times as often
constexpr double kJoined_s = 0.5;    // two stretches with less between them are one
constexpr double kExcess_a = 0.5;    // a current beyond a limit by less is its noise
constexpr std::uint8_t kNoCell = 255;

int cell_number(std::uint8_t index) { return index == kNoCell ? 0 : index + 1; }

/// The channel that is not believed, beside the faults that say so.
std::string suspect_text(std::size_t bit, const can::ContactorCommand& said) {
  const auto fault = static_cast<can::BmsFault>(bit);
  const bool named = fault == can::BmsFault::kCellImplausible || fault == can::BmsFault::kCurrentImplausible ||
                     fault == can::BmsFault::kTemperatureImplausible;
  if (!named || said.suspect_why == can::SuspectWhy::kNone) return {};
  const char* why = can::kSuspectWhyNames[static_cast<std::size_t>(said.suspect_why)];
  return said.suspect == kNoCell ? std::string(why) : fmt::format("channel {}: {}", said.suspect + 1, why);
}

}  // namespace

void Said::take(const Frame& frame) {
  if (decode(frame, contactors) || decode(frame, limits) || decode(frame, bms)) return;
  static_cast<void>(decode(frame, master));
}

void FirmwareWatch::note_faults(double time_s, const Said& said) {
  // At power-on nothing has been heard yet: what is still missing when the BMS is ready is told then.
  if (said.bms.state == can::BmsState::kInvalid) return;
  const bool active = said.bms.state == can::BmsState::kTsActive;
  const bool opens = was_active_ && !active;
  was_active_ = active;
  const std::uint32_t bms = said.bms.faults & ~bms_faults_, master = said.master.faults & ~master_faults_;
  bms_faults_ = said.bms.faults;
  master_faults_ = said.master.faults;
  for (std::size_t bit = 0; bms >> bit != 0 && bit < std::size(can::kBmsFaultNames); ++bit) {
    if ((bms >> bit & 1U) == 0) continue;
    result_.faults.push_back({can::kBmsFaultNames[bit], "bms", time_s, opens, suspect_text(bit, said.contactors)});
  }
  for (std::size_t bit = 0; master >> bit != 0 && bit < std::size(can::kMasterFaultNames); ++bit) {
    if ((master >> bit & 1U) != 0) result_.faults.push_back({can::kMasterFaultNames[bit], "master", time_s, false, {}});
  }
}

void FirmwareWatch::tick(double time_s, const Said& said, const LoggedMoment& logged) {
  note_faults(time_s, said);
  if (!begun_) next_row_s_ = time_s;
  begun_ = true;
  if (time_s >= next_row_s_ - 1e-9) {
    note_row(time_s, said, logged);
    next_row_s_ += kRow_s;
  }
  if (!with_model_ || said.bms.state != can::BmsState::kTsActive || !std::isfinite(logged.current_a)) return;
  follow_limit(false, time_s, logged.current_a, 1e-3 * said.limits.discharge_limit_ma, said);
  follow_limit(true, time_s, -logged.current_a, 1e-3 * said.limits.charge_limit_ma, said);
}

void FirmwareWatch::note_row(double time_s, const Said& said, const LoggedMoment& logged) {
  ReplayRow row;
  row.time_s = time_s;
  row.current_a = logged.current_a;
  row.cell_min_v = logged.cell_min_v;
  row.cell_max_v = logged.cell_max_v;
  row.temperature_max_c = logged.temperature_max_c;
  row.logged_soc = logged.soc;
  row.logged_discharge_limit_a = logged.discharge_limit_a;
  row.logged_charge_limit_a = logged.charge_limit_a;
  row.state = said.bms.state;
  row.faults = said.bms.faults;
  if (with_model_) {
    if (said.bms.soc_ok) row.soc = 1e-6 * said.bms.soc_ppm;
    row.discharge_limit_a = 1e-3 * said.limits.discharge_limit_ma;
    row.charge_limit_a = 1e-3 * said.limits.charge_limit_ma;
    row.limiting_cell = cell_number(said.limits.limiting_cell);
  }
  row.discharge_reason = said.limits.discharge_reason;
  row.charge_reason = said.limits.charge_reason;
  result_.rows.push_back(row);
}

void FirmwareWatch::follow_limit(bool charging, double time_s, double current_a, double limit_a, const Said& said) {
  Open& open = charging ? charge_ : discharge_;
  if (current_a <= limit_a + kExcess_a) {
    if (!open.running || time_s - open.stretch.end_s <= kJoined_s) return;
    result_.over_limits.push_back(open.stretch);
    open.running = false;
    return;
  }
  OverLimit& stretch = open.stretch;
  if (!open.running) stretch = OverLimit{charging, time_s, time_s, time_s, current_a, limit_a};
  stretch.end_s = time_s;
  if (!open.running || current_a - limit_a > stretch.excess_a()) {
    stretch.worst_s = time_s;
    stretch.current_a = current_a;
    stretch.limit_a = limit_a;
    stretch.reason = charging ? said.limits.charge_reason : said.limits.discharge_reason;
    stretch.cell = charging ? 0 : cell_number(said.limits.limiting_cell);
  }
  open.running = true;
}

void FirmwareWatch::finish() {
  for (Open* open : {&discharge_, &charge_}) {
    if (open->running) result_.over_limits.push_back(open->stretch);
    open->running = false;
  }
}

}  // namespace voltlap::plant
