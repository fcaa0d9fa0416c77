// SPDX-License-Identifier: Apache-2.0
#include "bms/cell_check.hpp"

#include "base/interpolate.hpp"
#include "base/require.hpp"
#include "bms/slow_mean.hpp"
#include "bms/state.hpp"

namespace voltlap::bms {
namespace {

constexpr Duration kFast = Duration::from_ms(1'600);     // chosen: longer than sensor lags, shorter than a corner
constexpr Duration kLag = Duration::from_ms(300);        // chosen: a channel of a cell is not slower
constexpr Duration kSoon = Duration::from_ms(50);        // half of how often a cell of a long pack is read
constexpr Duration kMemory = Duration::from_ms(4'000);   // chosen: a frozen channel is known after 4 s of driving
constexpr Duration kLevel = Duration::from_ms(10'000);   // chosen: several changes of the current
constexpr Duration kAtRest = Duration::from_ms(200);     // a reset has not to wait for what is over
constexpr std::int64_t kHides = 3;               // a third of the slower changes; chosen, a lap has a tenth
constexpr std::int64_t kLeastShare = 3;          // a third of its part; chosen, a sound cell has half of it and more
constexpr std::int32_t kLeastRest = 100;         // [per mille] that a cell which sags most leaves the others
constexpr std::int64_t kExcitation = 50;         // [0.1 mV] 5 mV a cell; in 40 samples 20 times an Orion's noise
constexpr std::int64_t kSlowShare = 4;           // a quarter of the current's changes; chosen
constexpr std::uint8_t kInARow = 5;              // samples; chosen, the lag of a channel behind the pack's is shorter
constexpr std::int64_t kChopped = 100;           // [0.1 mV] 10 mV; a third of the level's margin
constexpr std::int64_t kChoppedTimes = 100;      // ten times that much, squared, beside slower changes; chosen
constexpr std::int32_t kStartSpread = 100'000;   // [ppm] a cell's own difference that is believed
constexpr std::int32_t kSpread = 30'000;         // [ppm] of SOC, error of a start that did not rest long
constexpr std::int32_t kCapacityPercent = 25;    // a cell's capacity against its neighbours' (15 % and twice as much)
constexpr std::int32_t kLevelMargin = 300;       // [0.1 mV] channels of real harnesses: 10 mV each, rounded up
constexpr std::int64_t kLoadPercent = 50;        // of R |I|: 40 % more or less resistance, gradients of temperature
constexpr std::int64_t kSagPercent = 50;         // more of it downwards: slow branches age more than the fast answer
constexpr std::int64_t kSagUnseen = 200;         // and so much before any answer was seen: aged three times
constexpr std::int64_t kSagMost = 1'500;         // never more
constexpr std::int64_t kSeenTimes = 3;           // of the table that a resistance is believed; chosen

constexpr std::int64_t scaled(CellVoltage v) { return std::int64_t{v.raw()} * 256; }

/// I R in 0.1 mV / 256: mA uOhm are nV. Held within 400 V, so that a level fits 32 bits whatever the table says.
std::int64_t drop(std::int64_t ma, Resistance r) {
  constexpr std::int64_t kMost = 1'000'000'000;
  const std::int64_t all = ma * r.raw() / 100'000 * 256;
  return all < -kMost ? -kMost : (all > kMost ? kMost : all);
}

std::int32_t followed(std::int32_t mean, std::int64_t value, std::int64_t share) {
  return static_cast<std::int32_t>(follow(mean, value, share));
}

void follow_wave(Current current, PackVoltage pack, Instant now, PackWave& w) {
  const Duration gap = now - w.time;
  w.time = now;
  if (!w.begun) {
    w.begun = true;
    w.lagged = w.mean = w.followed = current.raw();
    w.pack_lagged = w.pack_mean = pack.raw();
  }
  const std::int64_t lag = share_of(gap, kLag, w.lag), mean = share_of(gap, kFast, w.fast);
  const std::int64_t memory = share_of(gap, kMemory, w.memory);
  w.lagged = followed(w.lagged, current.raw(), lag);
  w.mean = followed(w.mean, w.lagged, mean);
  w.followed = followed(w.followed, current.raw(), share_of(gap, kSoon, w.soon));
  w.x = w.lagged - w.mean;
  w.pack_lagged = followed(w.pack_lagged, pack.raw(), lag);
  w.pack_mean = followed(w.pack_mean, w.pack_lagged, mean);
  w.z = w.pack_lagged - w.pack_mean;
  const std::int64_t i = std::int64_t{current.raw()} - w.mean, x = w.x;
  const std::int64_t beyond = std::int64_t{current.raw()} - w.followed;
  w.all = follow(w.all, i * i, memory);
  w.chopped = follow(w.chopped, beyond * beyond, memory);
  w.slow = follow(w.slow, x * x, memory);
}

void begin(CellVoltage v, PackVoltage pack, Current i, Resistance r, CellTrack& t) {
  t.begun = true;
  t.voltage = static_cast<std::int32_t>(scaled(v));
  t.pack = pack.raw();
  t.level = static_cast<std::int32_t>(scaled(v) + drop(i.raw(), r));
}

struct Shares {
  std::int32_t fast, level, products;
};

/// With open contactors nothing has to be averaged out, and what was wrong under load is forgotten soon.
Shares shares_of(Duration gap, bool loaded, CellCheck& c) {
  const auto of = [&](Duration tau, LastShare& last) { return static_cast<std::int32_t>(share_of(gap, tau, last)); };
  return {of(kFast, c.fast), of(loaded ? kLevel : kAtRest, c.slow), of(loaded ? kMemory : kAtRest, c.memory)};
}

void take_sample(CellVoltage cell, PackVoltage pack, const PackWave& w, const Shares& share, CellTrack& t) {
  const std::int32_t v = cell.raw() * 256;
  t.voltage = follow_near(t.voltage, v, share.fast);
  t.pack = follow_near(t.pack, pack.raw(), share.fast);
  const std::int32_t x = w.x - t.pack_answer.x_mean, y = v - t.voltage, y16 = y / 64;
  t.xy = follow(t.xy, std::int64_t{x} * (y - t.y_mean), share.products);
  t.yy = follow(t.yy, std::int64_t{y16} * y16, share.fast);
  t.y_mean = follow_near(t.y_mean, y, share.products);
  t.x_lagged = follow(t.x_lagged, std::int64_t{x} * (w.z - t.lagged_mean), share.products);
  t.lagged_mean = follow_near(t.lagged_mean, w.z, share.products);
  take(w.x, pack.raw() - t.pack, share.products, t.pack_answer);
}

/// Covariances with the current, of a cell's voltage and of the pack's [mA 0.1 mV], positive for a sag.
struct Answer {
  std::int64_t own, all;
};

Answer answer(const CellTrack& t) {
  const std::int64_t sampled = -t.pack_answer.xz, lagged = -t.x_lagged;
  return {-t.xy / 256, sampled < lagged ? sampled : lagged};
}

/// The current explains enough of what the pack does to judge a cell by.
bool explained(const Config& config, const CellTrack& t, std::int64_t all) {
  return explains(t.pack_answer, all, kExcitation * config.cells_in_series);
}

bool slow_enough(const PackWave& w) { return w.slow >= w.all / kSlowShare; }

/// Of the cells that share the rest; of two none can be told to sag too much.
std::int64_t others_of(const Config& config) {
  return config.cells_in_series > 2 ? config.cells_in_series - 1 : config.cells_in_series;
}

/// By a third of its part of what the pack does, whatever made it.
bool moves(const Config& config, const CellTrack& t) {
  const std::int64_t parts = kLeastShare * config.cells_in_series;
  return t.yy >= t.pack_answer.zz * 4'096 / (parts * parts);
}

/// The current changes enough about as often as a cell is read to make one answer to nothing.
bool drifts(const PackWave& w) { return w.chopped * kHides * kHides >= w.slow; }

// BMS-060
bool no_answer(const Config& config, const CellCheck& c, const CellTrack& t) {
  const Answer a = answer(t);
  const bool enough = a.own * kLeastShare * others_of(config) * kAllAnswers >= a.all * c.rest;
  if (enough || !slow_enough(c.wave) || !explained(config, t, a.all)) return false;
  return !drifts(c.wave) || !moves(config, t);
}

/// What the cell that sags most leaves to the others.
std::int32_t rest_without(const CellTrack& most) {
  const Answer a = answer(most);
  if (a.all <= 0 || a.own <= 0) return kAllAnswers;
  const std::int64_t left = (a.all - a.own) * kAllAnswers / a.all;
  return left < kLeastRest ? kLeastRest : static_cast<std::int32_t>(left);
}

CellVoltage ocv(const Config& config, std::int64_t soc) {
  return interpolate(config.ocv.soc, config.ocv.voltage, config.ocv.count, Soc::saturated(soc));
}

Soc soc_of(const Config& config, std::int64_t level) {
  const CellVoltage voltage = CellVoltage::saturated(level / 256);
  return interpolate(config.ocv.voltage, config.ocv.soc, config.ocv.count, voltage);
}

/// How much lower a cell may lie because it sags more than the others, in per cent of R |I|.
std::int64_t sag_percent(const Config& config, const CellTrack& t) {
  const Answer a = answer(t);
  if (config.cells_in_series < 2 || !explained(config, t, a.all)) return kSagUnseen;
  const std::int64_t others = (a.all - a.own) / (config.cells_in_series - 1);
  if (others <= 0) return kSagUnseen;
  const std::int64_t more = (a.own - others) * 100 / others;
  return more < 0 ? 0 : (more > kSagMost ? kSagMost : more);
}

// BMS-061
bool off_level(const Config& config, const CellCheck& c, const CellTrack& t) {
  if (!c.based) return false;
  const std::int64_t apart = (std::int64_t{t.level} - c.level) / 256;
  const std::int64_t margin = kLevelMargin + c.sag * kLoadPercent / 100;
  if (-margin <= apart && apart <= margin) return false;  // whatever its charge
  const std::int32_t drawn = c.start < c.soc ? (c.soc - c.start).raw() : (c.start - c.soc).raw();
  const std::int64_t spread = kSpread + std::int64_t{drawn} * kCapacityPercent / 100;
  const std::int32_t own = (t.start - c.start).raw();
  const std::int64_t base = ocv(config, c.soc.raw()).raw();
  if (apart > 0) {
    const std::int32_t above = own < 0 ? 0 : (own > kStartSpread ? kStartSpread : own);
    // What sags more under a load rises more in a charge.
    const std::int64_t rise = c.rise == 0 ? 0 : c.rise * (sag_percent(config, t) * 3 / 2 + kSagPercent) / 100;
    return apart > ocv(config, c.soc.raw() + above + spread).raw() - base + margin + rise;
  }
  const std::int32_t below = own > 0 ? 0 : (own < -kStartSpread ? -kStartSpread : own);
  if (c.soc.raw() + below - spread < 0) return false;  // below the end of the table anything is possible
  const std::int64_t sag = c.sag * (sag_percent(config, t) * 3 / 2 + kSagPercent) / 100;
  return apart < ocv(config, c.soc.raw() + below - spread).raw() - base - margin - sag;
}

void count_in_a_row(bool now, std::uint8_t& samples) {
  if (!now) samples = 0;
  if (now && samples < kInARow) ++samples;
}

/// `sag`: drop() at the current of this step, which is that of every cell that came in it.
void take_and_judge(const Config& config, Instant now, std::size_t i, std::int64_t sag, State& s) {
  CellCheck& c = s.cell_check;
  CellTrack& t = c.cell[i];
  const CellVoltage voltage = s.measured.cell[i].value;
  if (!t.begun) {
    begin(voltage, s.measured.cell_pack[i], s.measured.cell_current[i], s.cell_resistance, t);
  } else {
    const Shares share = shares_of(now - t.time, commanded(s.contactors.command), c);
    take_sample(voltage, s.measured.cell_pack[i], c.wave, share, t);
    t.level = followed(t.level, scaled(voltage) + sag, share.level);
  }
  t.time = now;
  count_in_a_row(no_answer(config, c, t), t.no_answer);
  if (!c.chopped) count_in_a_row(off_level(config, c, t), t.off_level);
}

/// Cells of this step beside a current and a pack voltage of this step: what one of them has not seen yet, none has.
void take_arrived(const Config& config, Instant now, State& s) {
  const Measured& m = s.measured;
  if (!m.current.good() || !m.pack_voltage.good() || (now - m.current.time).ms() != 0) return;
  follow_wave(m.current.value, m.pack_voltage.value, now, s.cell_check.wave);
  const std::int64_t sag = drop(m.current.value.raw(), s.cell_resistance);
  for_each_arrived(config, m, [&](std::size_t i) {
    if (m.cell[i].good() && !m.bled[i]) take_and_judge(config, now, i, sag, s);  // BMS-055
  });
}

/// The first rest after power-on: where every cell stands.
void find_start(const Config& config, State& s) {
  CellCheck& c = s.cell_check;
  if (c.based || !s.pack.complete_once || !s.pack.cells_good || s.cell_resistance <= Resistance{}) return;
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    CellTrack& t = c.cell[i];
    begin(s.measured.cell[i].value, s.measured.cell_pack[i], s.measured.cell_current[i], s.cell_resistance, t);
    t.start = soc_of(config, t.level);
    sum += t.start.raw();
  }
  c.start = Soc::saturated(sum / config.cells_in_series);
  c.based = true;
}

/// Mean of the neighbours: all cells but the lowest; and who is accused.
void renew_neighbours(const Config& config, State& s) {
  CellCheck& c = s.cell_check;
  std::int64_t levels = 0;
  std::int32_t lowest = c.cell[0].level;
  std::size_t sags_most = 0;
  c.frozen = c.off_level = kNoCell;
  for (std::uint16_t i = config.cells_in_series; i-- > 0;) {
    const CellTrack& t = c.cell[i];
    levels += t.level;
    if (t.level < lowest) lowest = t.level;
    if (t.xy < c.cell[sags_most].xy) sags_most = i;
    if (t.no_answer >= kInARow) c.frozen = static_cast<std::uint8_t>(i);
    if (t.off_level >= kInARow) c.off_level = static_cast<std::uint8_t>(i);
  }
  const bool without = config.cells_in_series > 2;
  c.level = static_cast<std::int32_t>((levels - (without ? lowest : 0)) / others_of(config));
  c.rest = without ? rest_without(c.cell[sags_most]) : kAllAnswers;
  c.soc = soc_of(config, c.level);
}

/// The current changes so fast, and moves a cell by so much, that a cell may always be read at the same moment of it.
bool is_chopped(const PackWave& w, Resistance r) {
  if (r <= Resistance{}) return false;
  const std::int64_t least_ma = kChopped * 100'000 / r.raw();
  return w.all - w.slow >= least_ma * least_ma * (slow_enough(w) ? kChoppedTimes : 1);
}

/// What the pack's answer says of a cell, where the current explains it; the table may be wrong by two.
Resistance seen_resistance(const Config& config, const Covariance& pack) {
  const std::int64_t sag = -pack.xz, cells = config.cells_in_series;
  if (!explains(pack, sag, kExcitation * cells) || pack.xx < kLeastSquare) return Resistance{};
  return Resistance::saturated(sag * 100 / (pack.xx / 1'000 * cells));  // 0.1 mV / mA is 100'000 uOhm
}

void renew_load(const Config& config, Instant now, State& s) {
  CellCheck& c = s.cell_check;
  c.chopped = is_chopped(c.wave, s.cell_resistance);
  const std::int64_t current = s.measured.current.value.raw();
  const Duration memory = commanded(s.contactors.command) ? kLevel : kAtRest;
  const std::int64_t share = share_of(now - c.renewed, memory);
  c.load = followed(c.load, current < 0 ? -current : current, share);
  c.net = followed(c.net, current, share);
  const Resistance seen = seen_resistance(config, s.current_check.answer);
  if (seen > Resistance{}) c.resistance = min(seen, Resistance::saturated(kSeenTimes * s.cell_resistance.raw()));
  c.rise = c.net < 0 ? static_cast<std::int32_t>(drop(-std::int64_t{c.net}, s.cell_resistance) / 256) : 0;
  c.sag = static_cast<std::int32_t>(drop(c.load, max(c.resistance, s.cell_resistance)) / 256);
  c.renewed = now;
}

}  // namespace

void check_cells(const Config& config, Instant now, bool slow, State& state) {
  VOLTLAP_REQUIRE(config.cells_in_series > 0 && config.cells_in_series <= kMaxCells);
  take_arrived(config, now, state);
  if (!slow) return;
  find_start(config, state);
  renew_load(config, now, state);
  renew_neighbours(config, state);
}

}  // namespace voltlap::bms
