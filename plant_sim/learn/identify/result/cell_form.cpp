// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_form.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSmallest_m3 = 0.5e-6, kLargest_m3 = 20e-3;  // half a coin cell; a module

std::string names() {
  std::string out;
  for (const CellForm& cylinder : named_cylinders()) out += cylinder.name + ", ";
  return out;
}

[[noreturn]] void refuse(const std::string& text, const std::string& why, const std::string& what_to_do) {
  throw InputError("--size", fmt::format("\"{}\"{}", text, why),
                   names() + "DIAMETERxLENGTH of another cylinder, or LENGTHxWIDTHxTHICKNESS of a pouch or can, in mm",
                   what_to_do);
}

/// The numbers between the x; empty when one is none.
std::vector<double> sides_of(std::string_view text) {
  if (text.ends_with("mm")) text.remove_suffix(2);
  std::vector<double> out;
  const char *at = text.data(), *end = text.data() + text.size();
  while (at != end) {
    double side = 0.0;
    const auto [next, error] = std::from_chars(at, end, side);
    if (error != std::errc{} || !std::isfinite(side) || !(side > 0.0)) return {};
    out.push_back(side);
    at = next;
    if (at == end) return out;
    if (*at != 'x' && *at != 'X') return {};
    ++at;
  }
  return {};  // empty, or an x at the end
}

}  // namespace

double CellForm::volume_m3() const {
  VOLTLAP_DEMAND(sides_mm.size() == 2 || sides_mm.size() == 3);
  if (is_cylinder()) return 1e-9 * std::numbers::pi / 4.0 * sides_mm[0] * sides_mm[0] * sides_mm[1];
  return 1e-9 * sides_mm[0] * sides_mm[1] * sides_mm[2];
}

double CellForm::surface_m2() const {
  VOLTLAP_DEMAND(sides_mm.size() == 2 || sides_mm.size() == 3);
  if (is_cylinder()) return 1e-6 * std::numbers::pi * sides_mm[0] * (sides_mm[1] + 0.5 * sides_mm[0]);
  return 2e-6 * (sides_mm[0] * sides_mm[1] + sides_mm[1] * sides_mm[2] + sides_mm[2] * sides_mm[0]);
}

std::string CellForm::text() const {
  const std::string size =
      fmt::format("a {} of {} mm", is_cylinder() ? "cylinder" : "box", fmt::join(sides_mm, " mm x "));
  return name.empty() ? size : name + ", " + size;
}

const std::vector<CellForm>& named_cylinders() {
  static const std::vector<CellForm> cylinders{
      {"18650", {18.35, 65.0}}, {"21700", {21.7, 70.2}}, {"26650", {26.0, 65.15}}};
  return cylinders;
}

CellForm cell_form(const std::string& text) {
  const auto named = std::find_if(named_cylinders().begin(), named_cylinders().end(),
                                  [&](const CellForm& cylinder) { return cylinder.name == text; });
  if (named != named_cylinders().end()) return *named;
  const CellForm form{"", sides_of(text)};
  if (form.sides_mm.size() != 2 && form.sides_mm.size() != 3)
    refuse(text, "", "Such as --size 21700, --size 22.1x71 or --size 127.5x42x10.7");
  if (form.is_cylinder() && form.sides_mm[0] > form.sides_mm[1]) {
    refuse(text, ", a cylinder wider than it is long",
           "Give the diameter first; a pouch or can has three numbers, the last its thickness");
  }
  if (form.volume_m3() < kSmallest_m3 || form.volume_m3() > kLargest_m3) {
    refuse(text, fmt::format(", which are {:.3g} cm3", 1e6 * form.volume_m3()),
           fmt::format("Millimetres, not metres or inches: a cell has {:g} to {:g} cm3", 1e6 * kSmallest_m3,
                       1e6 * kLargest_m3));
  }
  return form;
}

}  // namespace voltlap::plant
