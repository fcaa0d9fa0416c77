// SPDX-License-Identifier: Apache-2.0
// The nodes of one version of the firmware behind node_api.hpp. Compiled against the headers of that version: only what
// every version has stands here.
#include "node_api.hpp"

#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "base/require.hpp"

namespace same_firmware {
namespace {

using namespace voltlap;

Failed report_failure = nullptr;

template <class Quantity>
void take(Quantity& field, std::int32_t value) {
  if (value != kOwn) field = Quantity::from_raw(value);
}
void take(Duration& field, std::int32_t value) {
  if (value != kOwn) field = Duration::from_ms(value);
}
void take(std::int32_t& field, std::int32_t value) {
  if (value != kOwn) field = value;
}

void take_tables(const BmsSettings& s, bms::Config& c) {
  constexpr std::int32_t kFull = 1'000'000;
  c.ocv.count = 3;
  c.ocv.soc[1] = Soc::from_raw(kFull / 2);
  c.ocv.soc[2] = Soc::from_raw(kFull);
  c.ocv.voltage[0] = CellVoltage::from_raw(s.ocv_empty);
  c.ocv.voltage[1] = CellVoltage::from_raw(s.ocv_middle);
  c.ocv.voltage[2] = CellVoltage::from_raw(s.ocv_full);
  c.resistance.count = 2;
  c.resistance.soc[1] = Soc::from_raw(kFull);
  c.resistance.resistance[0] = Resistance::from_raw(s.resistance_empty);
  c.resistance.resistance[1] = Resistance::from_raw(s.resistance_full);
  c.resistance.ppm_per_kelvin = s.resistance_ppm_per_kelvin;
}

bms::Config config_of(const BmsSettings& s) {
  bms::Config c;
  c.cells_in_series = static_cast<std::uint16_t>(s.cells_in_series);
  c.temperature_sensors = static_cast<std::uint16_t>(s.temperature_sensors);
  c.capacity_mah = s.capacity_mah;
  take_tables(s, c);
  if (s.soc_method != kOwn) c.soc_method = static_cast<bms::SocMethod>(s.soc_method);
  take(c.discharge_current_max, s.discharge_current_max);
  take(c.charge_current_max, s.charge_current_max);
  take(c.discharge_current_trip, s.discharge_current_trip);
  take(c.charge_current_trip, s.charge_current_trip);
  take(c.limit_rise_per_s, s.limit_rise_per_s);
  take(c.soc_derating_start, s.soc_derating_start);
  take(c.derating_start, s.derating_start);
  take(c.charge_temperature_min, s.charge_temperature_min);
  take(c.voltage_trip_time, s.voltage_trip_time);
  take(c.temperature_trip_time, s.temperature_trip_time);
  take(c.current_trip_time, s.current_trip_time);
  take(c.measurement_lost_time, s.measurement_lost_time);
  take(c.mismatch_time, s.mismatch_time);
  take(c.contactor_time, s.contactor_time);
  take(c.precharge_timeout, s.precharge_timeout);
  take(c.precharge_time_min, s.precharge_time_min);
  take(c.discharge_time, s.discharge_time);
  take(c.balancing_voltage_min, s.balancing_voltage_min);
  return c;
}

master::Config config_of(const MasterSettings& s) {
  master::Config c;
  take(c.phase_current_max, s.phase_current_max);
  take(c.request_rise_ma_per_ms, s.request_rise_ma_per_ms);
  take(c.regen_current_max, s.regen_current_max);
  take(c.pedal_dead_zone, s.pedal_dead_zone);
  if (s.arbitration != kOwn) c.arbitration = static_cast<master::Arbitration>(s.arbitration);
  take(c.motor_constant_unm_per_a, s.motor_constant_unm_per_a);
  take(c.drive_efficiency, s.drive_efficiency);
  take(c.power_max_mw, s.power_max_mw);
  take(c.ceiling_rise_ma_per_s, s.ceiling_rise_ma_per_s);
  take(c.trim_gain, s.trim_gain);
  take(c.motor_derate_start, s.motor_derate_start);
  take(c.ts_request_timeout, s.ts_request_timeout);
  take(c.rtd_sound_time, s.rtd_sound_time);
  take(c.rx_timeout, s.rx_timeout);
  return c;
}

void* create(Which which, const Settings& settings) {
  if (which == Which::kBms) return new app::BmsNode(config_of(settings.bms));
  return new app::MasterNode(config_of(settings.master));
}

void destroy(Which which, void* node) {
  if (which == Which::kBms) {
    delete static_cast<app::BmsNode*>(node);
  } else {
    delete static_cast<app::MasterNode*>(node);
  }
}

std::size_t tick(Which which, void* node, std::uint32_t now_ms, const WireFrame* rx, std::size_t count, WireFrame* tx) {
  constexpr std::size_t kReceivedMax = 128;
  Frame in[kReceivedMax];
  if (count > kReceivedMax) report_failure("more frames in a tick than the comparison has room for");
  for (std::size_t i = 0; i < count; ++i) {
    in[i].id = rx[i].id;
    in[i].dlc = rx[i].dlc;
    for (std::size_t k = 0; k < Frame::kMaxBytes; ++k) in[i].data[k] = rx[i].data[k];
  }
  TxQueue out;
  const Instant now = Instant::from_ms(now_ms);
  if (which == Which::kBms) {
    static_cast<app::BmsNode*>(node)->tick(now, FrameView{in, count}, out);
  } else {
    static_cast<app::MasterNode*>(node)->tick(now, FrameView{in, count}, out);
  }
  static_assert(TxQueue::kCapacity <= kSentMax);
  for (std::size_t i = 0; i < out.size(); ++i) {
    tx[i].id = out[i].id;
    tx[i].dlc = out[i].dlc;
    for (std::size_t k = 0; k < Frame::kMaxBytes; ++k) tx[i].data[k] = out[i].data[k];
  }
  return out.size();
}

constexpr NodeApi kApi{create, destroy, tick};

}  // namespace
}  // namespace same_firmware

namespace voltlap {

void require_failed(const char* condition, const char* /*file*/, int /*line*/) {
  same_firmware::report_failure(condition);
  __builtin_trap();
}

}  // namespace voltlap

extern "C" __attribute__((visibility("default"))) const same_firmware::NodeApi* same_firmware_nodes(
    same_firmware::Failed failed) {
  same_firmware::report_failure = failed;
  return &same_firmware::kApi;
}
