// SPDX-License-Identifier: Apache-2.0
// The roles of a map as signals, in SI.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "io/logs/channel_builder.hpp"
#include "io/logs/drive_log.hpp"
#include "io/logs/plot/plotted_signals.hpp"

namespace voltlap::plant {
namespace {

/// The unit that a role has in a DriveLog: the one of its quantity with the size 1.
std::string unit_of_role(const std::string& role) {
  for (const std::string_view name : units_of(role)) {
    const Unit unit = unit_of("role", std::string(name));
    if (!unit.quantity.empty() && unit.scale == 1.0 && unit.offset == 0.0) return std::string(name);
  }
  return {};
}

class RoleSignals : public PlottedSignals {
 public:
  RoleSignals(const SignalSources& sources, const DataFolder& data) {
    RoleMap map;
    if (!sources.map.empty()) map = load_role_map(data.find("maps", sources.map, "--map"));
    log_ = read_drive_log(sources.recording, sources.map.empty() ? nullptr : &map, data);
    double first = INFINITY, last = -INFINITY;
    for (const auto& [role, channel] : log_.channels) {
      if (channel.size() == 0) continue;
      heads_.push_back({role, unit_of_role(role), channel.source});
      channels_.push_back(&channel);
      first = std::min(first, channel.time_s.front());
      last = std::max(last, channel.time_s.back());
      facts_.frames += channel.size();
    }
    VOLTLAP_DEMAND(!channels_.empty());
    begin_s_ = first;
    facts_.duration_s = last - first;
    facts_.format = "roles by " + log_.map;
    facts_.start = start_text(log_.origin_s + (is_absolute(log_.origin_s) ? first : 0.0));
    tell();
  }

  void read(const SampleSink& sink, const ReadProgress&) override {
    for (std::size_t k = 0; k < channels_.size(); ++k) {
      const Channel& channel = *channels_[k];
      VOLTLAP_DEMAND(channel.time_s.size() == channel.value.size());
      for (std::size_t i = 0; i < channel.size(); ++i) sink(k, channel.time_s[i] - begin_s_, channel.value[i]);
    }
  }
  [[nodiscard]] const std::vector<SignalHead>& heads() const override { return heads_; }
  [[nodiscard]] std::vector<std::string> silent() const override { return log_.absent; }
  [[nodiscard]] const RecordingFacts& facts() const override { return facts_; }

 private:
  void tell();

  DriveLog log_;
  std::vector<SignalHead> heads_;
  std::vector<const Channel*> channels_;
  double begin_s_ = 0.0;
  RecordingFacts facts_;
};

void RoleSignals::tell() {
  for (const LogDefect& defect : log_.defects)
    facts_.notes.push_back((defect.channel.empty() ? "" : defect.channel + ": ") + defect.text);
  std::map<std::string, std::size_t> masked;
  for (const MaskedStretch& stretch : log_.masked) masked[stretch.channel + ": " + stretch.reason] += stretch.count;
  for (const auto& [what, count] : masked) {
    if (count > 0) facts_.notes.push_back(fmt::format("{}: {} samples are not shown", what, count));
  }
  for (const std::string& note : log_.notes) facts_.notes.push_back(note);
  for (const std::string& role : log_.absent) facts_.notes.push_back(role + ": no sample in the recording");
}

}  // namespace

std::unique_ptr<PlottedSignals> role_signals(const SignalSources& sources, const DataFolder& data) {
  return std::make_unique<RoleSignals>(sources, data);
}

}  // namespace voltlap::plant
