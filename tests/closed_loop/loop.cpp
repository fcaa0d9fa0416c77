// SPDX-License-Identifier: Apache-2.0
#include "loop.hpp"

#include <algorithm>
#include <iterator>

#include "apps/firmware_config.hpp"
#include "fixtures.hpp"

namespace voltlap::plant::test {

FrameView SilenceableLoop::left_of(FrameView rx) {
  if (!loses) return rx;
  left_.clear();
  std::copy_if(rx.begin(), rx.end(), std::back_inserter(left_), [this](const Frame& frame) { return !loses(frame); });
  return {left_.data(), left_.size()};
}

void SilenceableLoop::bms(Instant now, FrameView rx, TxQueue& tx) {
  firmware_.bms(now, left_of(rx), tx);
  if (now.ms() >= bms_silent_from_ms) tx.clear();
}

void SilenceableLoop::master(Instant now, FrameView rx, TxQueue& tx) {
  firmware_.master(now, left_of(rx), tx);
  if (now.ms() >= master_silent_from_ms) tx.clear();
}

void Record::on_frame(std::uint32_t tick, Sender sender, const Frame& frame) {
  if (hashes) hash.on_frame(tick, sender, frame);
}

EnduranceOptions nominal(int laps) {
  EnduranceOptions options;
  options.vehicle = vtm16e();
  options.track = michigan(2015);
  options.laps = laps;
  options.representative_cell = true;
  options.pedal_sensors = pedal_sensors(master_config(options.vehicle));
  return options;
}

EnduranceOptions study_row(int year) {
  EnduranceOptions options = nominal(year == 2015 ? 27 : 29);
  options.track = michigan(year);
  options.lap_start = LapStart::kStanding;
  return options;
}

EnduranceResult drive(const EnduranceOptions& options, Record& record) {
  FirmwareLoop firmware(options.vehicle);
  return run_endurance(options, firmware, record);
}

EnduranceResult drive(const EnduranceOptions& options) {
  Record record;
  return drive(options, record);
}

}  // namespace voltlap::plant::test
