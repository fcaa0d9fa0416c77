// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_listener.hpp"

#include <algorithm>
#include <cmath>

#include "bms/estimate/soc_ekf.hpp"
#include "can_dbc/car.hpp"

namespace voltlap::plant {
namespace {

constexpr double kCoarseRange_a = 500.0;  // LEM DHAB S/33 data sheet, coarse channel

double stepped(double value, double step) { return step > 0.0 ? step * std::round(value / step) : value; }

template <class Quantity>
void scale(Quantity& quantity, double factor) {
  quantity = Quantity::saturated(std::llround(factor * quantity.raw()));
}

}  // namespace

void SocScore::add(double error_points) {
  squares_ += error_points * error_points;
  largest_ = std::max(largest_, std::abs(error_points));
  ++samples_;
}

double SocScore::rms() const { return samples_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(samples_)); }

bms::Config mistaken(bms::Config config, const SocErrors& errors) {
  config.capacity_mah = static_cast<std::int32_t>(std::lround(errors.capacity * config.capacity_mah));
  for (std::size_t i = 0; i < config.resistance.count; ++i) {
    scale(config.resistance.resistance[i], errors.resistance);
    scale(config.branches.series[i], errors.resistance);
    scale(config.branches.branch1[i], errors.resistance);
    scale(config.branches.branch2[i], errors.resistance);
  }
  return config;
}

SocListener::SocListener(const bms::Config& config, const SocErrors& errors, const SensorSection& sensors,
                         std::uint64_t seed)
    : config_(mistaken(config, errors)), errors_(errors), sensors_(sensors), random_(seed) {
  if (!errors.restarted) node_.emplace(config_);
}

std::int32_t SocListener::current_ma(std::int32_t truth_ma, bool rests) {
  double a = 1e-3 * truth_ma;
  const bool fine = std::abs(a) <= sensors_.current_low_range_a;
  const double range_a = fine ? sensors_.current_low_range_a : kCoarseRange_a;
  a *= errors_.current_gain;
  if (!rests) a += errors_.current_offset * range_a;
  if (errors_.noise) a += normal_(random_) * (fine ? sensors_.current_low_noise_a : sensors_.current_high_noise_a);
  if (errors_.quantisation) a = stepped(a, fine ? sensors_.current_low_step_a : sensors_.current_high_step_a);
  return static_cast<std::int32_t>(std::lround(1e3 * a));
}

std::int32_t SocListener::cell_100uv(std::int32_t truth_100uv) {
  double v = errors_.voltage_gain * 1e-4 * truth_100uv + errors_.voltage_offset_v;
  if (errors_.noise) v += normal_(random_) * sensors_.cell_noise_v;
  if (errors_.quantisation) v = stepped(v, sensors_.cell_step_v);
  return static_cast<std::int32_t>(std::lround(1e4 * v));
}

/// The frame with what this BMS is told in the place of the truth, sealed anew.
Frame SocListener::heard(const Frame& frame, bool rests) {
  Frame out = frame;
  can::PackSensor pack;
  can::CellVoltages cells;
  if (can::decode(frame, pack)) {
    pack.pack_current_ma = current_ma(pack.pack_current_ma, rests);
    can::encode(pack, out);
  } else if (can::decode(frame, cells)) {
    for (std::int32_t& v : cells.cell_100uv) v = cell_100uv(v);
    can::encode(cells, out);
  } else {
    return out;
  }
  sealer_.seal(out);
  return out;
}

void SocListener::tick(Instant now, FrameView rx, bool rests) {
  if (!node_) return;
  heard_.clear();
  for (const Frame& frame : rx) heard_.push_back(heard(frame, rests));
  TxQueue unheard;
  node_->tick(now, FrameView{heard_.data(), heard_.size()}, unheard);
}

void SocListener::begin(const SocTruth& truth) {
  bms::SocRecord record;
  record.cells = config_.cells_in_series;
  for (std::size_t i = 0; i < record.cells; ++i) {
    const double soc = truth.cells[i] + 1e-2 * errors_.start_points;
    record.cell[i].soc = static_cast<std::int16_t>(std::lround(16'384.0 * soc));
  }
  node_.emplace(config_);
  node_->restore_soc(record);
}

double SocListener::soc() const { return 1e-6 * node_->state().soc.value.raw(); }

double SocListener::cell_soc(std::size_t cell) const {
  if (config_.soc_method != bms::SocMethod::kEkf) return soc();
  return 1e-6 * bms::cell_soc(node_->state().soc, cell).raw();
}

void SocListener::judge(const SocTruth& truth) {
  if (!node_ || !node_->state().soc.valid) return;
  const auto lowest = std::min_element(truth.cells.begin(), truth.cells.end());
  pack_.add(100.0 * (soc() - truth.pack));
  weakest_.add(100.0 * (cell_soc(static_cast<std::size_t>(lowest - truth.cells.begin())) - *lowest));
}

}  // namespace voltlap::plant
