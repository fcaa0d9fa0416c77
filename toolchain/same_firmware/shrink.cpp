// SPDX-License-Identifier: Apache-2.0
#include "shrink.hpp"

#include <algorithm>
#include <set>

#include "settings.hpp"

namespace same_firmware {
namespace {

constexpr std::uint64_t kReplayedStepsMax = 4'000'000;  // some ten seconds

class Shrinking {
 public:
  Shrinking(const Versions& versions, Difference input) : versions_(versions), best_(std::move(input)) { cut_tail(); }

  void leave_out_steps() {
    for (std::size_t size = std::max<std::size_t>(best_.steps.size() / 2, 1); size > 0; size /= 2) {
      for (std::size_t at = 0; at + size < best_.steps.size() && affordable();) {
        Difference shorter = best_;
        const auto first = shorter.steps.begin() + static_cast<std::ptrdiff_t>(at);
        shorter.steps.erase(first, first + static_cast<std::ptrdiff_t>(size));
        if (!keep_if_different(std::move(shorter))) at += size;
      }
    }
  }

  void leave_out_kinds_of_frames() {
    std::set<std::uint32_t> ids;
    for (const Step& step : best_.steps) {
      for (const WireFrame& frame : step.rx) ids.insert(frame.id);
    }
    for (const std::uint32_t id : ids) {
      Difference without = best_;
      for (Step& step : without.steps) std::erase_if(step.rx, [id](const WireFrame& f) { return f.id == id; });
      keep_if_different(std::move(without));
    }
  }

  void leave_out_frames() {
    for (std::size_t at = 0; at < best_.steps.size() && affordable(); ++at) {
      for (std::size_t i = best_.steps[at].rx.size(); i-- > 0 && at < best_.steps.size();) {
        if (i >= best_.steps[at].rx.size()) continue;
        Difference without = best_;
        without.steps[at].rx.erase(without.steps[at].rx.begin() + static_cast<std::ptrdiff_t>(i));
        keep_if_different(std::move(without));
      }
    }
  }

  void leave_out_settings() {
    Settings by_itself;
    const std::vector<NamedSetting> own = settings_by_name(by_itself);
    for (std::size_t i = 0; i < own.size(); ++i) {
      Difference without = best_;
      *settings_by_name(without.settings)[i].value = *own[i].value;
      keep_if_different(std::move(without));
    }
  }

  Difference take() { return std::move(best_); }

 private:
  [[nodiscard]] bool affordable() const { return replayed_ < kReplayedStepsMax; }

  void cut_tail() { best_.steps.resize(std::min(first_difference(versions_, best_) + 1, best_.steps.size())); }

  bool keep_if_different(Difference candidate) {
    const std::size_t at = first_difference(versions_, candidate);
    replayed_ += std::min(at + 1, candidate.steps.size());
    if (at == candidate.steps.size()) return false;
    candidate.steps.resize(at + 1);
    best_ = std::move(candidate);
    return true;
  }

  const Versions& versions_;
  Difference best_;
  std::uint64_t replayed_ = 0;
};

}  // namespace

std::size_t first_difference(const Versions& versions, const Difference& input) {
  Pair pair(versions, input.which, input.settings);
  for (std::size_t i = 0; i < input.steps.size(); ++i) {
    if (input.steps[i].restart) pair.restart();
    if (!pair.tick(input.steps[i].now_ms, input.steps[i].rx)) return i;
  }
  return input.steps.size();
}

Difference shrink(const Versions& versions, Difference input) {
  Shrinking shrinking(versions, std::move(input));
  shrinking.leave_out_steps();
  shrinking.leave_out_kinds_of_frames();
  shrinking.leave_out_settings();
  shrinking.leave_out_steps();
  shrinking.leave_out_frames();
  return shrinking.take();
}

}  // namespace same_firmware
