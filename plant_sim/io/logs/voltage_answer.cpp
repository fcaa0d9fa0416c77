// SPDX-License-Identifier: Apache-2.0
#include "io/logs/voltage_answer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostBlocks = 20000;

/// Last value, for at most so many blocks.
void hold(std::vector<double>& values, std::size_t longest) {
  std::size_t since = longest + 1;
  for (std::size_t k = 0; k < values.size(); ++k) {
    since = std::isfinite(values[k]) ? 0 : since + 1;
    if (since > 0 && since <= longest) values[k] = values[k - since];
  }
}

struct Steps {
  std::vector<double> a, b;
};

Steps steps_of(const std::vector<double>& a, const std::vector<double>& b, std::size_t lag) {
  Steps out;
  for (std::size_t k = lag; k < a.size(); ++k) {
    const double da = a[k] - a[k - lag], db = b[k] - b[k - lag];
    if (!std::isfinite(da) || !std::isfinite(db)) continue;
    out.a.push_back(da);
    out.b.push_back(db);
  }
  return out;
}

/// A contactor or a spike counts no more than the largest of the usual steps. Returns that size.
double clip(std::vector<double>& steps) {
  std::vector<double> sizes;
  for (const double step : steps) {
    if (step != 0.0) sizes.push_back(std::abs(step));
  }
  const double usual = quantile(std::move(sizes), 0.99);
  for (double& step : steps) step = std::clamp(step, -usual, usual);
  return usual;
}

struct Moments {
  double aa = 0.0, bb = 0.0, ab = 0.0;
  [[nodiscard]] double correlation() const { return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0; }
};

Moments moments_of(const Steps& steps) {
  Moments out;
  double mean_a = 0.0, mean_b = 0.0;
  for (std::size_t k = 0; k < steps.a.size(); ++k) {
    mean_a += steps.a[k];
    mean_b += steps.b[k];
  }
  const double count = std::max<double>(1.0, static_cast<double>(steps.a.size()));
  mean_a /= count;
  mean_b /= count;
  for (std::size_t k = 0; k < steps.a.size(); ++k) {
    const double da = steps.a[k] - mean_a, db = steps.b[k] - mean_b;
    out.aa += da * da;
    out.bb += db * db;
    out.ab += da * db;
  }
  return out;
}

}  // namespace

BlockMeans::BlockMeans(const RecordedSignals& recording) : is_can_(recording.is_can) {
  if (!is_can_) {
    const std::size_t rows = recording.signals.empty() ? 0 : recording.signals.front().value.size();
    rows_a_block_ = rows / kMostBlocks + 1;
    blocks_ = rows / rows_a_block_;
    return;
  }
  double end_s = -std::numeric_limits<double>::infinity();
  begin_s_ = -end_s;
  for (const RecordedSignal& signal : recording.signals) {
    begin_s_ = std::min(begin_s_, signal.time_s.front());
    end_s = std::max(end_s, signal.time_s.back());
  }
  if (!(end_s > begin_s_)) return;
  block_s_ = std::max(0.1, (end_s - begin_s_) / static_cast<double>(kMostBlocks));
  blocks_ = static_cast<std::size_t>((end_s - begin_s_) / block_s_) + 1;
}

std::vector<double> BlockMeans::of(const RecordedSignal& signal) const {
  constexpr std::size_t kLongestHold = 10;  // blocks
  std::vector<double> sum(blocks_, 0.0), count(blocks_, 0.0);
  for (std::size_t k = 0; k < signal.value.size(); ++k) {
    if (!std::isfinite(signal.value[k])) continue;
    const std::size_t block =
        is_can_ ? static_cast<std::size_t>(std::max(0.0, (signal.time_s[k] - begin_s_) / block_s_))
                : k / rows_a_block_;
    if (block >= blocks_) continue;
    sum[block] += signal.value[k];
    count[block] += 1.0;
  }
  for (std::size_t block = 0; block < blocks_; ++block)
    sum[block] = count[block] > 0.0 ? sum[block] / count[block] : kNothing;
  hold(sum, kLongestHold);
  VOLTLAP_DEMAND(sum.size() == blocks_);
  return sum;
}

std::size_t VoltageAnswer::best_lag() const {
  std::size_t best = 0;
  for (std::size_t k = 1; k < correlation.size(); ++k) {
    if (std::abs(correlation[k]) > std::abs(correlation[best])) best = k;
  }
  return best;
}

VoltageAnswer voltage_answer(const std::vector<double>& current, const std::vector<double>& voltage) {
  constexpr double kLarge = 0.1;  // of the largest usual step
  VOLTLAP_DEMAND(current.size() == voltage.size());
  VoltageAnswer out;
  for (std::size_t k = 0; k < VoltageAnswer::kLags.size(); ++k) {
    Steps steps = steps_of(current, voltage, VoltageAnswer::kLags[k]);
    const double usual = clip(steps.a);
    clip(steps.b);
    if (k == 0) {
      out.steps = static_cast<std::size_t>(std::count_if(steps.a.begin(), steps.a.end(), [&](double step) {
        return usual > 0.0 && std::abs(step) > kLarge * usual;
      }));
    }
    const Moments moments = moments_of(steps);
    out.correlation[k] = moments.correlation();
    out.slope[k] = moments.aa > 0.0 ? moments.ab / moments.aa : 0.0;
  }
  return out;
}

bool is_same_course(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double kSame = 0.9995;
  const VoltageAnswer answer = voltage_answer(a, b);
  return std::all_of(answer.correlation.begin(), answer.correlation.end(),
                     [](double r) { return std::abs(r) > kSame; });
}

}  // namespace voltlap::plant
