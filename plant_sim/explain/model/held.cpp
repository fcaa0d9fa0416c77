// SPDX-License-Identifier: Apache-2.0
#include "explain/model/held.hpp"

#include <cmath>

#include "explain/balances/car_balances.hpp"
#include "explain/model/interpolated.hpp"

namespace voltlap::explain {
namespace {

constexpr double kMinute_s = 60.0;

/// Leaves out the bins of the other minutes.
void keep_minutes(ReadChannel& channel, double from_s, Minutes minutes) {
  std::vector<bool> kept;
  std::vector<Index> rows;
  for (Index k = 0; k < channel.reader.size(); ++k) {
    const auto minute = static_cast<long>((channel.reader.time_s()(k) - from_s) / kMinute_s);
    kept.push_back((minute % 2 == 0) == (minutes == Minutes::kEven));
    if (kept.back()) rows.push_back(k);
  }
  channel.reader.keep(kept);
  channel.residual = VectorXd(channel.residual(rows));
  channel.rough = VectorXd(channel.rough(rows));
}

void put_left(const Family& family, const std::string& unit, std::map<std::string, LeftOf>& out) {
  const Fit fit = fit_of(family.problem, {});
  for (std::size_t c = 0; c < family.channel.size(); ++c) out[family.channel[c]] = left_in(family, fit, c, unit);
}

}  // namespace

Held held_against(const plant::World& given, plant::Recording read, const Holding& how) {
  Held out;
  out.world = given;
  if (read.temperatures_of_core) out.world.car.cell.surface_lag_s = 0.0;
  const plant::World& model = out.world;
  plant::Comparison comparison = plant::comparison_of(model, interpolated(model, std::move(read)), how.compared);
  if (comparison.log.derived.contains("motor_speed")) {
    // As the car's speed is, and the slip that its tyres have by the model.
    comparison.log.signals["motor_speed"] = plant::car_prediction("motor_speed", model, comparison, {});
    comparison = plant::comparison_of(model, std::move(comparison.log), how.compared);
  }
  out.seen = observed(model, std::move(comparison));
  if (how.beginning != Beginning::kByItself) out.seen.begins_charged = how.beginning == Beginning::kCharged;
  if (how.minutes == Minutes::kAll) return out;
  const double from_s = out.log().time_s(0);
  for (ReadChannel& channel : out.seen.channels) keep_minutes(channel, from_s, how.minutes);
  for (Member& member : out.seen.members) keep_minutes(member.channel, from_s, how.minutes);
  return out;
}

LeftOf left_in(const Family& family, const Fit& fit, std::size_t channel, const std::string& unit) {
  const auto row = static_cast<Index>(channel);
  return {fit.left.row(row).transpose().cwiseMax(0.0), std::max(1.0, family.problem.channels[channel].all[0].count),
          std::sqrt(fit.variance(row)), unit};
}

plant::ChannelGain gain_of(const LeftOf& before, const LeftOf& after) {
  const auto drop = [](double from, double to) { return from > 0.0 ? 1.0 - std::sqrt(to / from) : 0.0; };
  const double from = before.squares.sum(), to = after.squares.sum(), whole = drop(from, to);
  const auto blocks = static_cast<double>(before.squares.size());
  double square = 0.0;
  for (Index b = 0; b < before.squares.size() && b < after.squares.size(); ++b) {
    const double without = drop(from - before.squares(b), std::max(0.0, to - after.squares(b)));
    square += (blocks - 1.0) / blocks * (without - whole) * (without - whole);
  }
  const double half = 1.96 * std::sqrt(square);
  return {std::sqrt(from / before.count),
          std::sqrt(to / after.count),
          after.noise,
          whole - half,
          std::min(1.0, whole + half),
          after.unit};
}

std::map<std::string, LeftOf> left_of(const Observed& log) {
  std::map<std::string, LeftOf> out;
  put_left(global_family(log, {}, all_suspects), "", out);
  for (const ReadChannel& channel : log.channels) out[channel.name].unit = channel.unit;
  for (const Member& member : log.members) {
    if (member.channel.reader.size() > 0)
      put_left(member_family(log, member, {}, all_suspects), member.channel.unit, out);
  }
  return out;
}

}  // namespace voltlap::explain
