// SPDX-License-Identifier: Apache-2.0
#include "io/bus/bus_load.hpp"

#include <algorithm>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kPercent = 100.0;
constexpr double kSecondsPerMs = 1e-3;

}  // namespace

double BusLoadResult::frames_per_s(const BusLoadRow& row) const {
  return time_s > 0.0 ? static_cast<double>(row.frames) / time_s : 0.0;
}

double BusLoadResult::load_pct(const BusLoadRow& row) const {
  return time_s > 0.0 ? kPercent * static_cast<double>(row.bits) / (bit_rate * time_s) : 0.0;
}

double BusLoadResult::share_pct(const BusLoadRow& row) const {
  return total_pct > 0.0 ? kPercent * load_pct(row) / total_pct : 0.0;
}

BusLoad::BusLoad(std::uint32_t tick_ms, std::uint32_t bit_rate)
    : tick_ms_(tick_ms), bit_rate_(bit_rate), window_(tick_ms > 0 ? std::max(1U, kWindow_ms / tick_ms) : 0) {
  VOLTLAP_DEMAND(tick_ms > 0 && bit_rate > 0);
}

BusLoad::Counter& BusLoad::counter(std::uint32_t id) {
  std::size_t place = 0;
  if (id < kStandardIds) {
    place = index_[id];
  } else if (const auto found = extended_.find(id); found != extended_.end()) {
    place = found->second;
  }
  if (place != 0) return counters_[place - 1];
  Counter& out = counters_.emplace_back();
  out.row.id = id;
  for (std::uint8_t dlc = 0; dlc <= Frame::kMaxBytes; ++dlc) out.heads[dlc] = frame_head(id, dlc);
  if (id < kStandardIds) {
    index_[id] = static_cast<std::uint16_t>(counters_.size());
  } else {
    extended_[id] = counters_.size();
  }
  return out;
}

void BusLoad::go_to(std::uint32_t tick) {
  VOLTLAP_DEMAND(tick > tick_);
  peak_ = std::max(peak_, in_window_);
  // After a silence as long as the window nothing of before is in it.
  const std::uint32_t from = tick - tick_ > window_.size() ? tick - static_cast<std::uint32_t>(window_.size()) : tick_;
  for (std::uint32_t t = from + 1; t <= tick; ++t) {
    std::uint64_t& oldest = window_[t % window_.size()];
    VOLTLAP_DEMAND(oldest <= in_window_);
    in_window_ -= oldest;
    oldest = 0;
  }
  tick_ = tick;
}

void BusLoad::on_frame(std::uint32_t tick, Sender, const Frame& frame) {
  if (tick != tick_) go_to(tick);
  Counter& c = counter(frame.id);
  const std::uint32_t bits = frame_bits(c.heads[frame.dlc], frame);
  ++c.row.frames;
  c.row.bits += bits;
  c.row.bits_worst = std::max(c.row.bits_worst, bits);
  window_[tick % window_.size()] += bits;
  in_window_ += bits;
}

BusLoadResult BusLoad::result() const {
  BusLoadResult out;
  out.bit_rate = bit_rate_;
  if (counters_.empty()) return out;
  out.time_s = (static_cast<double>(tick_) + 1.0) * tick_ms_ * kSecondsPerMs;
  const double window_s = static_cast<double>(window_.size()) * tick_ms_ * kSecondsPerMs;
  out.peak_100ms_pct = kPercent * static_cast<double>(std::max(peak_, in_window_)) / (bit_rate_ * window_s);
  for (const Counter& c : counters_) {
    out.rows.push_back(c.row);
    out.total_pct += out.load_pct(c.row);
  }
  std::sort(out.rows.begin(), out.rows.end(), [](const BusLoadRow& a, const BusLoadRow& b) { return a.id < b.id; });
  return out;
}

}  // namespace voltlap::plant
