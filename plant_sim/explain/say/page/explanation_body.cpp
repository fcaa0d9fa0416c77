// SPDX-License-Identifier: Apache-2.0
#include "explain/say/page/explanation_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "explain/say/numbers.hpp"
#include "explain/say/page/race_rows.hpp"
#include "explain/say/page/residual_map.hpp"
#include "explain/say/page/shown_channel.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMaskedShown = 200;

std::string number_text(const FoundParameter& p) {
  if (p.unit == "name") return p.text;
  if (p.unit == "index") return fmt::format("{:.0f}", p.value);
  if (p.name == "count") return fmt::format("{:.0f} rows", p.value);
  const double half = 0.5 * (p.high - p.low) * p.shown_scale;
  const std::string unit = p.shown_unit.empty() ? p.unit : p.shown_unit;
  if (!(half > 0.0)) return fmt::format("{:.4g} {}", p.value * p.shown_scale, unit);
  const int digits = decimals_of(half);
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f}) {}", p.value * p.shown_scale, digits, p.low * p.shown_scale,
                     digits, p.high * p.shown_scale, digits, unit);
}

const FoundParameter* main_number(const FoundCause& cause) {
  const auto found = std::find_if(cause.parameters.begin(), cause.parameters.end(),
                                  [](const FoundParameter& p) { return p.unit != "name" && p.unit != "index"; });
  return found == cause.parameters.end() ? nullptr : &*found;
}

std::string share_text(double share) {
  return fmt::format("{:.0f}", 100.0 * share);
}

/// The channel whose error falls most.
const std::pair<const std::string, ChannelGain>* best_gain(const Explanation& e) {
  const std::pair<const std::string, ChannelGain>* best = nullptr;
  const auto drop = [](const ChannelGain& g) { return g.before > 0.0 ? 1.0 - g.after / g.before : 0.0; };
  for (const auto& entry : e.gain) {
    if (drop(entry.second) > (best == nullptr ? 0.0 : drop(best->second))) best = &entry;
  }
  return best;
}

/// Found in the log itself, before any comparison with the model.
bool is_of_gate(const FoundCause& cause) {
  return cause.d_prime == 0.0 && cause.share_of_residual == 0.0;
}

std::string cause_tiles(const Explanation& e) {
  if (e.causes.empty()) return "";
  const FoundCause& cause = e.causes.front();
  if (is_of_gate(cause)) {
    const FoundParameter* p = main_number(cause);
    return p == nullptr ? "" : html_tile(cause.name, number_text(*p), "", cause.says);
  }
  std::string out;
  if (const FoundParameter* p = main_number(cause)) {
    const double half = 0.5 * (p->high - p->low) * p->shown_scale;
    const int digits = decimals_of(half);
    out += html_tile(cause.name, fmt::format("{:.{}f}", p->value * p->shown_scale, digits),
                     p->shown_unit.empty() ? p->unit : p->shown_unit,
                     half > 0.0 ? fmt::format("95 % between {:.{}f} and {:.{}f}", p->low * p->shown_scale, digits,
                                              p->high * p->shown_scale, digits)
                                : "measured in the log itself");
  }
  out += html_tile("Probability", share_text(cause.probability), "%",
                   cause.equivalent_to.empty() ? "of this cause" : "of this cause or one that acts alike");
  if (cause.share_of_residual > 0.0) {
    out += html_tile("Explains", share_text(cause.share_of_residual), "%", "of the mean square error it acts on");
  }
  return out;
}

/// The channel that is most times its noise away from the simulation.
std::string farthest_tile(const Explanation& e) {
  const auto ratio = [](const Trace& t) { return rms_of(t.before) / std::max(t.floor, 1e-12); };
  const auto most = std::max_element(e.traces.begin(), e.traces.end(),
                                     [&](const Trace& a, const Trace& b) { return ratio(a) < ratio(b); });
  const double rms = rms_of(most->before);
  const ShownUnit shown = shown_unit(most->unit, rms);
  return html_tile("Farthest off", shown_number(shown.scale * rms), shown.unit,
                   fmt::format("{}, RMS; {:.1f} times its noise", channel_words(most->channel), ratio(*most)));
}

std::string tiles(const ReportedExplanation& reported) {
  const Explanation& e = reported.explanation;
  std::string out = cause_tiles(e);
  if (const auto* best = best_gain(e)) {
    const ChannelGain& g = best->second;
    const ShownUnit shown = shown_unit(g.unit, g.before);
    const int digits = decimals_of(shown.scale * std::max(g.after, 0.1 * g.before));
    out += html_tile(
        "Error where not fitted",
        fmt::format("{:.{}f} → {:.{}f}", shown.scale * g.before, digits, shown.scale * g.after, digits), shown.unit,
        fmt::format("{}, RMS; its noise is {:.2g}", channel_words(best->first), shown.scale * g.floor));
  } else if (!e.traces.empty()) {
    out += farthest_tile(e);
    out += html_tile("Compared", fmt::format("{}", e.traces.size()), "channels",
                     e.with_references ? "against what reference logs leave over" : "without reference logs");
  }
  out += race_tiles(reported.race);
  return out.empty() ? "" : "<dl class=\"tiles\">\n" + out + "</dl>\n";
}

std::string cause_rows(const Explanation& e) {
  std::string out;
  for (const FoundCause& cause : e.causes) {
    std::string size;
    for (const FoundParameter& p : cause.parameters) {
      size += fmt::format("<div><small>{}</small> {}</div>", html_text(p.name), html_text(number_text(p)));
    }
    const bool gate = is_of_gate(cause);
    out += fmt::format(
        "<tr><th scope=\"row\"><b>{}</b><small>{}</small></th><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td></tr>\n",
        html_text(cause.name), html_text(cause.says), size, gate ? "–" : share_text(cause.share_of_residual),
        share_text(cause.probability), gate ? "–" : fmt::format("{:.1f}", cause.d_prime),
        html_text(cause.equivalent_to.empty() ? "–" : fmt::format("{}", fmt::join(cause.equivalent_to, ", "))));
  }
  return out;
}

std::string gain_rows(const Explanation& e) {
  std::string out;
  for (const auto& [name, g] : e.gain) {
    const ShownUnit shown = shown_unit(g.unit, g.before);
    const double drop = g.before > 0.0 ? 100.0 * (1.0 - g.after / g.before) : 0.0;
    const std::string interval =
        fmt::format("{:.0f} ({:.0f} to {:.0f})", drop, 100.0 * g.drop_low, 100.0 * g.drop_high);
    out += html_row({channel_words(name), shown_number(shown.scale * g.before), shown_number(shown.scale * g.after),
                     shown_number(shown.scale * g.floor), shown.unit, std::abs(drop) < 0.05 ? "–" : interval});
  }
  return out;
}

std::string rival_rows(const Explanation& e) {
  std::string out;
  for (const RunnerUp& rival : e.runners_up) {
    constexpr double kMost = 13.8;  // ln of a million
    const double odds = std::exp(std::min(rival.behind, kMost));
    out += html_row({fmt::format("{}", fmt::join(rival.names, " and ")), fmt::format("{:.1f}", rival.behind),
                     rival.behind < 0.0     ? "–"
                     : rival.behind > kMost ? "more than a million"
                                            : fmt::format("{:.{}f}", odds, odds < 10.0 ? 1 : 0),
                     rival.why});
  }
  return out;
}

/// What cannot be told apart, and what would tell.
std::string open_questions(const Explanation& e) {
  std::string out;
  const auto line = [&](const std::string& text) { out += "<p>" + html_text(text) + "</p>\n"; };
  for (const FoundCause& cause : e.causes) {
    if (cause.equivalent_to.empty()) continue;
    line(fmt::format("This log cannot tell {} from {}.", cause.name, fmt::join(cause.equivalent_to, ", ")));
  }
  if (!e.alternatives.empty()) {
    std::vector<std::string> sets;
    for (const auto& names : e.alternatives) sets.push_back(fmt::format("{}", fmt::join(names, " with ")));
    line(fmt::format("Each of these explains the log: {}.", fmt::join(sets, "; or ")));
  }
  if (e.unknown_in) line(fmt::format("What is wrong sits in the {} balance.", name_of(*e.unknown_in)));
  if (!e.next_test.empty()) line(fmt::format("The test that would tell: {}.", e.next_test));
  if (out.empty()) line("Nothing: no other known cause comes near.");
  return out;
}

std::string masked_rows(const Explanation& e) {
  std::string out;
  for (std::size_t k = 0; k < e.masked.size() && k < kMaskedShown; ++k) {
    const Masked& m = e.masked[k];
    out += html_row({m.channel, fmt::format("{:.1f}", m.start_s), fmt::format("{:.1f}", m.end_s), m.reason});
  }
  if (e.masked.size() > kMaskedShown) {
    const std::string more = fmt::format("and {} stretches more", e.masked.size() - kMaskedShown);
    out += html_row({more, "", "", "all of them in --json"});
  }
  return out.empty() ? html_row({"nothing", "", "", "every row was used"}) : out;
}

std::string note_items(const Explanation& e) {
  std::string out;
  for (const std::string& note : e.notes) out += "<li>" + html_text(note) + "</li>\n";
  return out;
}

std::string facts(const ReportedExplanation& reported) {
  std::string out = html_fact("mode", reported.explanation.with_references
                                          ? "reference: new is what differs from the reference logs"
                                          : "absolute: no reference log, the floor comes from this log");
  for (const auto& [name, value] : reported.run) out += html_fact(name, value);
  return out + html_fact("version", reported.version);
}

/// Word and colour of a verdict.
std::pair<const char*, const char*> status_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNamed:
      return {"good", "✓ Named"};
    case Verdict::kAmbiguous:
      return {"open", "Ambiguous"};
    case Verdict::kUnknown:
      return {"open", "Unknown cause"};
    case Verdict::kNoDiscrepancy:
      return {"good", "✓ No discrepancy"};
    default:
      return {"bad", "✕ Too little data"};
  }
}

std::string section(const char* asset, const std::string& rows) {
  return rows.empty() ? "" : fill_template(html_asset(asset, explanation_page_files), {{"rows", rows}});
}

}  // namespace

std::string explanation_body(const ReportedExplanation& reported) {
  const Explanation& e = reported.explanation;
  const auto [status_class, status] = status_of(e.verdict);
  return fill_template(html_asset("explain.html", explanation_page_files),
                       {{"status_class", status_class},
                        {"status", status},
                        {"headline", html_text(e.sentence)},
                        {"tiles", tiles(reported)},
                        {"causes", section("explain_causes.html", cause_rows(e))},
                        {"map", section("explain_map.html", residual_map(e))},
                        {"gain", section("explain_gain.html", gain_rows(e))},
                        {"race", race_section(reported.race)},
                        {"rivals", section("explain_rivals.html", rival_rows(e))},
                        {"questions", open_questions(e)},
                        {"masked_rows", masked_rows(e)},
                        {"notes", note_items(e)},
                        {"run_facts", facts(reported)}});
}

}  // namespace voltlap::plant
