// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/held_cells.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Rows at which the current is another than in the row before, by much.
std::vector<bool> moved_rows(const VectorXd& current) {
  constexpr double kMuch = 0.3;  // of its RMS
  const VectorXd known = current.array().isFinite().select(current, 0.0);
  const double much = kMuch * std::sqrt(known.squaredNorm() / std::max(1.0, static_cast<double>(known.size())));
  std::vector<bool> out(static_cast<std::size_t>(current.size()), false);
  for (Index row = 1; row < current.size(); ++row)
    out[static_cast<std::size_t>(row)] = std::abs(current(row) - current(row - 1)) > much;
  return out;
}

/// How a cell stands from row to row.
struct Standing {
  double moved = 0.0, stood = 0.0;  ///< rows in which the current moved, and the cell did not
  std::vector<Index> turns;         ///< rows from one change to the next
};

Standing standing_of(const VectorXd& volts, const std::vector<bool>& moved) {
  Standing out;
  Index changed = -1;
  for (Index row = 1; row < volts.size(); ++row) {
    if (!std::isfinite(volts(row)) || !std::isfinite(volts(row - 1))) continue;
    const bool stands = volts(row) == volts(row - 1);
    if (moved[static_cast<std::size_t>(row)]) {
      out.moved += 1.0;
      out.stood += stands ? 1.0 : 0.0;
    }
    if (stands) continue;
    if (changed >= 0) out.turns.push_back(row - changed);
    changed = row;
  }
  return out;
}

Index at_part(std::vector<Index> values, double part) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Rows of a turn: how long a value stands that the current would have changed. 1 where it follows each row.
Index turn_of(const Recording& log, const std::vector<std::string>& cells, const std::vector<bool>& moved) {
  constexpr double kStood = 0.3, kLeastMoved = 20.0, kFew = 0.1;
  Standing all;
  for (const std::string& role : cells) {
    const Standing one = standing_of(*log.find(role), moved);
    if (one.turns.size() < 2) continue;  // stands for the whole log
    all.moved += one.moved;
    all.stood += one.stood;
    all.turns.insert(all.turns.end(), one.turns.begin(), one.turns.end());
  }
  const double least = kLeastMoved * static_cast<double>(cells.size());
  if (all.moved < least || all.stood < kStood * all.moved || all.turns.empty()) return 1;
  // The shortest are a whole turn, if not one that came a row early.
  const Index shortest = at_part(all.turns, kFew);
  std::erase_if(all.turns, [&](Index turn) { return turn > 2 * shortest; });
  return shortest < 2 ? 1 : at_part(all.turns, 0.5);
}

/// When each row's value was read.
VectorXd read_of(const VectorXd& time_s, const VectorXd& volts, Index turn) {
  VectorXd out = time_s;
  Index last = 0;
  for (Index row = 1; row < volts.size(); ++row) {
    const bool stands = volts(row) == volts(row - 1);
    if (!stands || row - last > turn) last = row;
    out(row) = last == 0 ? time_s(0) : 0.5 * (time_s(last - 1) + time_s(last));
  }
  return out;
}

/// Of a voltage's changes from row to row, what no resistance makes of the current's, over what it makes.
double beside_current(const VectorXd& current, const VectorXd& volts) {
  double ii = 0.0, iv = 0.0, vv = 0.0;
  for (Index row = 1; row < volts.size(); ++row) {
    const double di = current(row) - current(row - 1), dv = volts(row) - volts(row - 1);
    if (!std::isfinite(di + dv)) continue;
    ii += di * di;
    iv += di * dv;
    vv += dv * dv;
  }
  return iv * iv > 0.0 ? std::sqrt(std::max(0.0, vv * ii / (iv * iv) - 1.0)) : 0.0;
}

/// Does the pack's voltage follow the current of its row, and the cells' mean, as read at other times, does not?
bool is_pack_nearer(const Recording& log, const VectorXd& mean) {
  constexpr double kWorse = 1.5;
  const VectorXd *pack = log.find("pack_voltage"), &current = *log.find("current");
  if (pack == nullptr || log.published_is_no_measurement || log.read_s.at("pack_voltage") != log.time_s) return false;
  return beside_current(current, mean) > kWorse * beside_current(current, *pack);
}

/// Where a load goes on or off some cells follow in that row and some in the next, whatever the resistance of each.
bool do_cells_disagree(const Recording& log, const std::vector<std::string>& cells, const VectorXd& mean) {
  constexpr double kMuch = 0.12;  // of the change: tables of 1 s a row have 0.24 to 0.37, steps of 20 mV 0.08
  double apart = 0.0, together = 0.0;
  for (const std::string& role : cells) {
    const VectorXd& volts = *log.find(role);
    double mm = 0.0, mv = 0.0, vv = 0.0;
    for (Index row = 1; row < mean.size(); ++row) {
      const double all = mean(row) - mean(row - 1), own = volts(row) - volts(row - 1);
      if (!std::isfinite(all + own)) continue;
      mm += all * all;
      mv += all * own;
      vv += own * own;
    }
    if (mm > 0.0) apart += vv - mv * mv / mm;
    together += mm;
  }
  return apart > kMuch * kMuch * together;
}

}  // namespace

void settle_held_cells(Recording& log) {
  const std::vector<std::string> cells = log.numbered("cell_voltage_");
  if (cells.size() < 2) return;
  for (const std::string& role : cells) {
    if (log.read_s.at(role) != log.time_s) return;  // frames of their own times
  }
  log.cells_at_rows = true;
  VectorXd mean = VectorXd::Zero(log.rows());
  for (const std::string& role : cells) mean += *log.find(role) / static_cast<double>(cells.size());
  log.pack_is_nearer = is_pack_nearer(log, mean);
  log.cells_apart = log.pack_is_nearer || do_cells_disagree(log, cells, mean);
  const Index turn = turn_of(log, cells, moved_rows(*log.find("current")));
  if (turn < 2) return;
  log.cells_apart = true;
  for (const std::string& role : cells) {
    log.read_s[role] = read_of(log.time_s, *log.find(role), turn);
    log.age_s[role] = log.time_s - log.read_s[role];
  }
}

VectorXd older_cells(const World& world, const VectorXd& time_s, const BatteryResponse& battery) {
  VectorXd out = VectorXd::Zero(time_s.size());
  if (world.cells_late_s != 0.0) out += shifted(time_s, battery.voltage_v, -world.cells_late_s) - battery.voltage_v;
  if (world.cells_held != 0.0) out += world.cells_held * (battery.drop_v.array() - battery.drop_v.mean()).matrix();
  return out;
}

}  // namespace voltlap::plant
