// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/energy_to_go.hpp"

#include "bms/charge/on_charger.hpp"
#include "bms/limits/method.hpp"
#include "bms/state.hpp"

namespace voltlap::bms {
namespace {

constexpr std::int64_t kPieceWay = std::int64_t{kPieceM} * 1'000'000 * 60'000;  // rpm um/turn ms is um / 60 000
// Chosen: the mean covers a kilometre, as much as a lap; at the least ratio a cap falls by 27 % in a kilometre.
constexpr std::int64_t kMeanPieces = 10, kSlowness = 16;
constexpr std::int64_t kOne = 1 << 10, kRatioMin = kOne / 2, kRatioMax = kOne + kOne / 2;
constexpr std::int64_t kPeakFade = 20;  // by a twentieth a piece
constexpr std::int64_t kLeastShare = 10;  // of the current that it began at: a car that crawls still comes home
constexpr int kTakenBits = 8;
constexpr Soc kCharged = Soc::from_raw(50'000);  // more than a cell's voltage at rest is wrong by; chosen

/// What may be taken in a piece, by what is taken [2^-10].
std::int64_t ratio_of(const Config& config, const EnergyToGo& e, Soc soc, std::int64_t pieces_left) {
  const Soc to_use = max(soc - config.energy_to_go_reserve, Soc{});
  if (e.taken <= 0) return kRatioMax;
  const std::int64_t ratio = std::int64_t{to_use.raw()} * (kOne << kTakenBits) / pieces_left / e.taken;
  return ratio < kRatioMin ? kRatioMin : (ratio > kRatioMax ? kRatioMax : ratio);
}

void count_taken(Soc soc, EnergyToGo& e) {
  const std::int64_t taken = std::int64_t{max(e.at_mark - soc, Soc{}).raw()} << kTakenBits;
  if (e.seen < kMeanPieces) ++e.seen;
  e.taken += static_cast<std::int32_t>((taken - e.taken) / e.seen);
}

void move_cap(const Config& config, std::int64_t ratio, EnergyToGo& e) {
  const Current most = config.discharge_current_max;
  if (e.cap == Current{}) {
    if (ratio < kOne) e.cap = e.began_at = min(e.peak, most);
    return;
  }
  const std::int64_t moved = std::int64_t{e.cap.raw()} * (kOne * kSlowness + ratio - kOne) / (kOne * kSlowness);
  e.cap = max(Current::saturated(moved), share_of_limit(e.began_at, 1, kLeastShare));
  const bool above_need = 4 * std::int64_t{e.cap.raw()} > 5 * std::int64_t{e.peak.raw()};
  if (ratio > kOne && (e.cap >= most || above_need)) e.cap = Current{};
}

void end_piece(const Config& config, const SocEstimate& soc, EnergyToGo& e) {
  if (e.pieces < kPiecesMost) ++e.pieces;
  e.peak = max(e.piece_peak, Current::saturated(e.peak.raw() * (kPeakFade - 1) / kPeakFade));
  e.piece_peak = Current{};
  count_taken(soc.value, e);
  e.at_mark = soc.value;
  const std::int64_t left = config.energy_to_go_m / kPieceM - e.pieces;
  if (left > 0) {
    move_cap(config, ratio_of(config, e, soc.value, left), e);
  } else {
    e.cap = Current{};  // what is driven beyond it is nobody's plan
  }
}

/// What was driven before the supply was lost counts, unless the pack has been charged since.
void begin(Soc soc, EnergyToGo& e) {
  if (soc > e.at_mark + kCharged) e.pieces = 0;
  e.at_mark = soc;
  e.began = true;
}

}  // namespace

void spread_charge(const Config& config, Duration elapsed, State& state) {
  EnergyToGo& e = state.energy_to_go;
  if (config.energy_to_go_m == 0 || !state.soc.valid) return;
  if (charges(state)) e = EnergyToGo{};
  if (!e.began) begin(state.soc.value, e);
  const Measured& m = state.measured;
  if (m.current.good()) e.piece_peak = max(e.piece_peak, m.current.value);
  if (!m.motor_speed.good()) return;
  const std::int64_t rpm = magnitude(m.motor_speed.value).raw();
  e.way += rpm * config.um_per_motor_turn * elapsed.ms();
  if (e.way < kPieceWay) return;
  e.way -= kPieceWay;
  end_piece(config, state.soc, e);
}

void lower_discharge_by_energy(const State& state, Limit& limit) {
  const Current cap = state.energy_to_go.cap;
  if (cap > Current{}) lower(limit, cap, can::LimitReason::kEnergyToGo);
}

void restore_way(const SocRecord& record, EnergyToGo& way) {
  way.pieces = record.pieces;
  way.at_mark = recorded_soc(record);
}

}  // namespace voltlap::bms
