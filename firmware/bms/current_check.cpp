// SPDX-License-Identifier: Apache-2.0
#include "bms/current_check.hpp"

#include "base/require.hpp"
#include "bms/slow_mean.hpp"
#include "bms/state.hpp"

namespace voltlap::bms {
namespace {

constexpr Current kOffsetMax = Current::from_raw(5'000);  // 5 A; chosen: 1 % of a channel of 500 A (LEM DHAB S/33)
constexpr std::uint8_t kFirstReadings = 16;               // 160 ms; noise of 1 A leaves 0.25 A
constexpr Duration kOffsetMemory = Duration::from_ms(10'000);
constexpr Duration kReadingCycle = Duration::from_ms(can::PackSensor::kCycleMs);
constexpr Duration kSettled = Duration::from_ms(500);     // after opening; chosen: lag of sensor and contactor
constexpr Duration kFast = Duration::from_ms(1'600);      // as in cell_check
constexpr Duration kMemory = Duration::from_ms(4'000);
constexpr Duration kAtRest = Duration::from_ms(200);       // open contactors: a reset has not to wait
constexpr std::int64_t kExcitationPerCell = 50;           // 5 mV
constexpr std::int64_t kMovesPerCell = 200;               // 20 mV: the voltage moves
constexpr std::int64_t kReversedPercent = 15;             // of the configured resistance, which may be wrong by 2
constexpr std::int64_t kFrozenFactor = 8;                 // the voltage moves so much more than the current explains
constexpr std::int64_t kExplainedMost = 20'000;           // [uV/mA], keeps the product inside 64 bits: a pack of 2 ohm
constexpr Duration kPowerMemory = Duration::from_ms(500);
constexpr std::int64_t kPowerLeast = 8'000'000;           // [mW] of the shaft, below it nothing is judged
constexpr std::int64_t kPowerLow = 60, kPowerHigh = 200;  // [%] of the shaft's power; losses make it more than 100
constexpr std::int64_t kPowerOther = 6'000'000;           // [mW] copper at low speed, low-voltage load

bool nothing_can_flow(Instant now, const State& s) {
  const VehicleIo& io = s.measured.io.value;
  const bool open = s.measured.io.good() && !io.air_plus_aux && !io.air_minus_aux && !io.precharge_aux;
  const bool settled = !s.contactors.closed_once || now - s.contactors.opened_at >= kSettled;
  return open && !commanded(s.contactors.command) && settled;
}

void follow_sag(Duration elapsed, State& s) {
  CurrentCheck& c = s.current_check;
  const std::int32_t i = s.measured.current.value.raw(), v = s.measured.pack_voltage.value.raw();
  if (!c.begun) {
    c.begun = true;
    c.current = i;
    c.voltage = v;
  }
  const std::int64_t fast = share_of(elapsed, kFast, c.fast);
  c.current = static_cast<std::int32_t>(follow(c.current, i, fast));
  c.voltage = static_cast<std::int32_t>(follow(c.voltage, v, fast));
  const Duration memory = commanded(s.contactors.command) ? kMemory : kAtRest;
  const auto share = static_cast<std::int32_t>(share_of(elapsed, memory, c.memory));
  take(i - c.current, v - c.voltage, share, c.answer);
}

/// What a resistance [uV/mA], kExplainedMost at most, explains of the voltage's changes, as zz.
std::int64_t explained(const Covariance& answer, std::int64_t per_ma) {
  return answer.xx / 100 * per_ma / 100 * per_ma / 256;
}

// BMS-066
void judge_sag(const Config& config, State& s) {
  CurrentCheck& c = s.current_check;
  const std::int64_t cells = config.cells_in_series, table = s.cell_resistance.raw();
  if (table <= 0) return;
  // mA uOhm are nV: 0.1 mV per 1e5 of them.
  const bool rises = c.answer.xz / cells * (100'000 * 100 / kReversedPercent) > c.answer.xx * table;
  c.reversed = rises && explains(c.answer, c.answer.xz, kExcitationPerCell * cells);
  const std::int64_t moves = kMovesPerCell * cells;
  const std::int64_t per_ma = table * cells * kFrozenFactor / 1'000;  // uV per mA that the current explains at most
  c.frozen = c.answer.zz >= moves * moves / 256 && per_ma <= kExplainedMost &&
             explained(c.answer, per_ma) < c.answer.zz;
}

// BMS-067
void judge_power(const Config& config, Duration elapsed, State& s) {
  CurrentCheck& c = s.current_check;
  const Measured& m = s.measured;
  c.power_judged = false;
  const bool known = config.motor_constant_unm_per_a > 0 && m.phase_current.good() && m.motor_speed.good() &&
                     m.dc_link_voltage.good();
  if (!known) return;
  // uNm/A rpm 0.10472 rad/s/rpm are uV: induced voltage in 0.1 mV
  const std::int64_t induced = std::int64_t{config.motor_constant_unm_per_a} * m.motor_speed.value.raw() / 955;
  const std::int64_t share = share_of(elapsed, kPowerMemory, c.power);
  c.shaft = follow(c.shaft, induced * m.phase_current.value.raw() / 10'000, share);
  c.battery = follow(c.battery, std::int64_t{m.pack_voltage.value.raw()} * m.current.value.raw() / 10'000, share);
  const std::int64_t size = induced < 0 ? -induced : induced;
  c.power_judged = c.shaft >= kPowerLeast && size * 10 <= std::int64_t{m.dc_link_voltage.value.raw()} * 6;
  const std::int64_t least = c.shaft * kPowerLow / 100, most = c.shaft * kPowerHigh / 100 + kPowerOther;
  c.power_wrong = c.battery < least || c.battery > most;
}

}  // namespace

// BMS-068
void learn_current_offset(Current raw, Instant now, State& s) {
  CurrentCheck& c = s.current_check;
  const bool open = nothing_can_flow(now, s);
  c.offset_too_large = open && (raw > kOffsetMax || -raw > kOffsetMax);
  if (!open || c.offset_too_large) return;
  if (c.readings < kFirstReadings) {
    ++c.readings;
    c.reading = Current::saturated(c.reading.raw() + (std::int64_t{raw.raw()} - c.reading.raw()) / c.readings);
  } else {
    c.reading_rest += (std::int64_t{raw.raw()} - c.reading.raw()) * share_of(kReadingCycle, kOffsetMemory);
    const std::int64_t step = c.reading_rest / 65'536;
    c.reading_rest -= step * 65'536;
    c.reading = Current::saturated(c.reading.raw() + step);
  }
  if (c.readings < kFirstReadings) return;
  c.offset_known = true;
  c.offset = c.reading;
}

void check_current(const Config& config, Instant now, Duration elapsed, State& s) {
  VOLTLAP_REQUIRE(config.cells_in_series > 0);
  const Measured& m = s.measured;
  // One frame has both.
  if (!m.current.good() || !m.pack_voltage.good() || (now - m.current.time).ms() != 0) return;
  follow_sag(elapsed, s);
  judge_sag(config, s);
  judge_power(config, elapsed, s);
}

}  // namespace voltlap::bms
