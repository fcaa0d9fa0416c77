// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_baseline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;
using Lines = std::vector<std::string>;

Json read_baseline(const std::string& path) {
  note_input(path);
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  Json out = Json::parse(text.str(), nullptr, false);
  if (!file || out.is_discarded() || !out.is_object() || !out.contains("frames_by_verdict")) {
    throw InputError("--baseline " + path, file ? "no result of a replay" : "no file that can be read",
                     "what voltlap replay --json wrote", "Make it first: voltlap replay LOG --json " + path);
  }
  return out;
}

std::string shown(const Json& value) {
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// What an entry of a list is about: its words without their numbers, and the cell.
std::string about(const Json& entry) {
  std::string text = entry.is_string() ? entry.get<std::string>() : "";
  const Json fields = entry.is_object() ? entry : Json::object();
  for (const auto& [key, value] : fields.items()) {
    if (value.is_string()) text += value.get<std::string>() + " ";
    if (key == "cell" && value.is_number_unsigned()) text += "cell " + std::string(value.get<std::size_t>(), '#');
  }
  std::erase_if(text, [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; });
  return text;
}

/// An entry in a line: its words first, then its numbers.
std::string told(const Json& entry) {
  if (!entry.is_object()) return shown(entry);
  std::string words, numbers;
  for (const auto& [key, value] : entry.items()) {
    if (value.is_string() && !value.get<std::string>().empty()) words += (words.empty() ? "" : ", ") + shown(value);
    if (value.is_number()) numbers += fmt::format("{}{} {}", numbers.empty() ? "" : ", ", key, shown(value));
    if (value.is_boolean() && value.get<bool>()) words += ", " + key;
  }
  return numbers.empty() ? words : fmt::format("{} ({})", words, numbers);
}

void compare_values(const std::string& name, const Json& was, const Json& is, Lines& out);

/// Two entries about the same thing that are not the same.
void compare_entries(const std::string& name, const Json& was, const Json& is, Lines& out) {
  if (!was.is_object() || !is.is_object()) {
    out.push_back(fmt::format("{}: {} -> {}", name, shown(was), shown(is)));
    return;
  }
  std::string words, moved;
  for (const auto& [key, value] : is.items()) {
    if (value.is_string() && words.empty()) words = shown(value);
    const auto before = was.find(key);
    if (before == was.end() || *before == value) continue;
    moved += fmt::format("{}{} {} -> {}", moved.empty() ? "" : ", ", key, shown(*before), shown(value));
  }
  out.push_back(fmt::format("{}, {}: {}", name, words, moved));
}

void compare_lists(const std::string& name, const Json& was, const Json& is, Lines& out) {
  std::vector<bool> taken(was.size(), false);
  for (const Json& entry : is) {
    const auto fits = [&](std::size_t k) { return !taken[k] && about(was[k]) == about(entry); };
    std::size_t k = 0;
    while (k < was.size() && !fits(k)) ++k;
    if (k == was.size()) {
      out.push_back(fmt::format("{}: new, {}", name, told(entry)));
      continue;
    }
    taken[k] = true;
    if (was[k] != entry) compare_entries(name, was[k], entry, out);
  }
  for (std::size_t k = 0; k < was.size(); ++k) {
    if (!taken[k]) out.push_back(fmt::format("{}: gone, {}", name, told(was[k])));
  }
}

/// Numbers of one step each; a curve that is longer by now differs in what both have.
void compare_series(const std::string& name, double step_s, const Json& was, const Json& is, Lines& out) {
  std::size_t differ = 0, farthest = 0;
  double most = -1.0;
  const std::size_t both = std::min(was.size(), is.size());
  for (std::size_t k = 0; k < both; ++k) {
    if (was[k] == is[k]) continue;
    ++differ;
    const double apart = was[k].is_number() && is[k].is_number() ? std::abs(was[k].get<double>() - is[k].get<double>())
                                                                  : 0.0;
    if (apart <= most) continue;
    most = apart;
    farthest = k;
  }
  if (differ > 0) {
    out.push_back(fmt::format("{}: differs in {} of {} points, the farthest {:.4g} s after the begin: {} -> {}", name,
                              differ, both, step_s * static_cast<double>(farthest), shown(was[farthest]),
                              shown(is[farthest])));
  }
  if (was.size() != is.size()) out.push_back(fmt::format("{}: {} -> {} points", name, was.size(), is.size()));
}

void compare_objects(const std::string& name, const Json& was, const Json& is, Lines& out) {
  const auto path = [&](const std::string& key) { return name.empty() ? key : name + "/" + key; };
  const double step_s = is.value("step_s", 0.0);
  for (const auto& [key, value] : is.items()) {
    const auto before = was.find(key);
    if (before == was.end()) {
      out.push_back(fmt::format("{}: new{}", path(key), value.is_structured() ? "" : ", " + shown(value)));
    } else if (step_s > 0.0 && before->is_array() && value.is_array()) {
      compare_series(path(key), step_s, *before, value, out);
    } else {
      compare_values(path(key), *before, value, out);
    }
  }
  for (const auto& [key, value] : was.items()) {
    if (!is.contains(key)) {
      out.push_back(fmt::format("{}: gone{}", path(key), value.is_structured() ? "" : ", " + shown(value)));
    }
  }
}

void compare_values(const std::string& name, const Json& was, const Json& is, Lines& out) {
  if (was == is) return;
  if (was.is_object() && is.is_object()) {
    compare_objects(name, was, is, out);
  } else if (was.is_array() && is.is_array()) {
    compare_lists(name, was, is, out);
  } else {
    out.push_back(fmt::format("{}: {} -> {}", name, shown(was), shown(is)));
  }
}

/// What no firmware changes: two results that differ in it are of two recordings.
std::string other_recording(const Json& was, const Json& is) {
  const auto differs = [&](const char* key) { return was.contains(key) && is.contains(key) && was[key] != is[key]; };
  if (!differs("frames")) return "";
  return fmt::format("the baseline is of another recording, or of one that was read otherwise: it had {} frames, there "
                     "are {}",
                     shown(was["frames"]), shown(is["frames"]));
}

Json compared(Json result) {
  for (const char* key : {"voltlap", "log", "map", "pack"}) result.erase(key);
  return result;
}

}  // namespace

std::vector<std::string> changes_since(const std::string& baseline_path, const std::string& now_json) {
  Lines out;
  const Json was = read_baseline(baseline_path), is = Json::parse(now_json);
  if (const std::string other = other_recording(was, is); !other.empty()) out.push_back(other);
  compare_objects("", compared(was), compared(is), out);
  return out;
}

std::vector<std::string> changes_between(const std::string& was_json, const std::string& is_json) {
  Lines out;
  compare_objects("", compared(Json::parse(was_json)), compared(Json::parse(is_json)), out);
  return out;
}

}  // namespace voltlap::plant
