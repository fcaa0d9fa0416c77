// SPDX-License-Identifier: Apache-2.0
#include "explain/say/page/residual_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "explain/say/numbers.hpp"
#include "explain/say/page/shown_channel.hpp"
#include "io/page/html_page.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kStretch = 60.0;  // s, or a whole multiple
constexpr double kMostStretches = 40.0;
constexpr std::size_t kMembers = 12;  // of a group
constexpr double kDarkest = 10.0;     // times the noise

/// RMS by stretch; negative where nothing was compared.
std::vector<double> rms_by_stretch(const VectorXd& time, const VectorXd& values, double length) {
  const auto count = static_cast<std::size_t>((time(time.size() - 1) - time(0)) / length) + 1;
  std::vector<double> square(count, 0.0), rows(count, 0.0);
  for (Index row = 0; row < time.size(); ++row) {
    if (!std::isfinite(values(row))) continue;
    const auto at = static_cast<std::size_t>((time(row) - time(0)) / length);
    square[at] += values(row) * values(row);
    rows[at] += 1.0;
  }
  for (std::size_t k = 0; k < count; ++k) square[k] = rows[k] > 0.0 ? std::sqrt(square[k] / rows[k]) : -1.0;
  return square;
}

std::string clock(double seconds) {
  const auto whole = static_cast<long>(std::lround(seconds));
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

/// Logarithmic from the noise itself to ten times it.
double heat_of(double ratio) {
  constexpr double kFull = 0.92;
  return kFull * std::clamp(std::log10(std::max(ratio, 1e-9)) / std::log10(kDarkest), 0.0, 1.0);
}

std::string cell(double rms, const Trace& trace, const ShownUnit& shown, double from, double length) {
  if (rms < 0.0) return "<td class=\"none\"></td>";
  const double ratio = trace.floor > 0.0 ? rms / trace.floor : 0.0;
  return fmt::format("<td style=\"--heat:{:.0f}%\" title=\"{}, {} to {}: {:.3g} {}, {:.1f} times the noise\"></td>",
                     100.0 * heat_of(ratio), html_text(trace.channel), clock(from), clock(from + length),
                     shown.scale * rms, html_text(shown.unit), ratio);
}

std::string row_of(const Explanation& e, const Trace& trace, bool after, double length) {
  const VectorXd& time = e.circumstances.time_s;
  const ShownUnit shown = shown_unit(trace.unit, rms_of(trace.before));
  const VectorXd& values = after ? trace.after : trace.before;
  std::string out = fmt::format("<tr><th scope=\"row\">{}</th><td class=\"value\">{} {}</td>",
                                html_text(channel_words(trace.channel)), shown_number(shown.scale * rms_of(values)),
                                html_text(shown.unit));
  double from = 0.0;
  for (const double rms : rms_by_stretch(time, values, length)) {
    out += cell(rms, trace, shown, from, length);
    from += length;
  }
  return out + "</tr>\n";
}

/// Of each group the members that are farthest off or that a cause changes, in their order.
std::vector<const Trace*> shown_traces(const Explanation& e, std::size_t& hidden) {
  std::vector<const Trace*> members, out;
  for (const Trace& trace : e.traces) {
    if (trace.member) members.push_back(&trace);
  }
  const auto size = [](const Trace* t) {
    return (is_changed(*t) ? 1e3 : 1.0) * rms_of(t->before) / std::max(t->floor, 1e-12);
  };
  std::vector<const Trace*> largest = members;
  std::stable_sort(largest.begin(), largest.end(),
                   [&](const Trace* a, const Trace* b) { return size(a) > size(b); });
  if (largest.size() > kMembers) largest.resize(kMembers);
  hidden = members.size() - largest.size();
  for (const Trace& trace : e.traces) {
    if (!trace.member || std::count(largest.begin(), largest.end(), &trace) > 0) out.push_back(&trace);
  }
  return out;
}

std::string table_of(const Explanation& e, const std::vector<const Trace*>& traces, bool after, double length) {
  const VectorXd& time = e.circumstances.time_s;
  const double span = time(time.size() - 1) - time(0);
  const auto columns = static_cast<int>(span / length) + 1;
  std::string out = fmt::format(
      "<table class=\"map\"><caption>{}</caption>\n<thead><tr><th scope=\"col\">channel</th><th "
      "scope=\"col\">RMS</th>"
      "<th scope=\"col\" colspan=\"{}\">time: {:.0f} s a column, {} in all</th></tr></thead>\n<tbody>\n",
      after ? "With what was found" : "As the model was given", columns, length, clock(span));
  for (const Trace* trace : traces) out += row_of(e, *trace, after, length);
  return out + "</tbody></table>\n";
}

}  // namespace

std::string residual_map(const Explanation& e) {
  const VectorXd& time = e.circumstances.time_s;
  if (e.traces.empty() || time.size() < 2) return "";
  const double span = time(time.size() - 1) - time(0);
  const double length = kStretch * std::max(1.0, std::ceil(span / kStretch / kMostStretches));
  std::size_t hidden = 0;
  const std::vector<const Trace*> traces = shown_traces(e, hidden);
  const bool changed = std::any_of(traces.begin(), traces.end(), [](const Trace* t) { return is_changed(*t); });
  std::string out = table_of(e, traces, false, length);
  if (changed) out += table_of(e, traces, true, length);
  if (hidden > 0) {
    out += fmt::format(
        "<p class=\"note\">{} cells and thermistors that are nearer to their mean are left out.</p>\n", hidden);
  }
  return out;
}

}  // namespace voltlap::plant
