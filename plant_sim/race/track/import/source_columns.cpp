// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/source_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

struct KnownNames {
  Quantity quantity;
  std::vector<const char*> names;  ///< letters and digits only, lower case
};

const std::vector<KnownNames>& known_names() {
  static const std::vector<KnownNames> names = {
      {Quantity::kX, {"x", "easting", "east", "e", "posx", "xpos", "positionx", "xposition", "utmx", "utme", "px"}},
      {Quantity::kY, {"y", "northing", "north", "n", "posy", "ypos", "positiony", "yposition", "utmy", "utmn", "py"}},
      {Quantity::kLatitude,
       {"lat", "latitude", "gpslat", "gpslatitude", "latgps", "latitudegps", "poslat", "vehiclelatitude"}},
      {Quantity::kLongitude,
       {"lon", "lng", "long", "longitude", "gpslon", "gpslong", "gpslng", "gpslongitude", "longitudegps", "poslon",
        "longps", "vehiclelongitude"}},
      {Quantity::kLeftX, {"leftx", "xleft", "lx", "outx", "outerx", "outsidex", "xout", "xouter", "xl"}},
      {Quantity::kLeftY, {"lefty", "yleft", "ly", "outy", "outery", "outsidey", "yout", "youter", "yl"}},
      {Quantity::kRightX, {"rightx", "xright", "rx", "inx", "innerx", "insidex", "xin", "xinner", "xr"}},
      {Quantity::kRightY, {"righty", "yright", "ry", "iny", "innery", "insidey", "yin", "yinner", "yr"}},
      {Quantity::kDistance, {"s", "distance", "dist", "station", "chainage", "arclength", "lapdistance", "sdistance"}},
      {Quantity::kCurvature, {"curvature", "kappa", "curv", "k", "c"}},
      {Quantity::kType, {"type", "sectiontype", "shape"}},
      {Quantity::kSectionLength, {"sectionlength", "length", "segmentlength", "len"}},
      {Quantity::kStraight, {"straight", "straightlength"}},
      {Quantity::kRadius, {"cornerradius", "radius", "r"}},
      {Quantity::kAngle, {"cornerangle", "angle", "turn"}},
  };
  return names;
}

/// Units at the end of a name.
constexpr const char* kUnits[] = {"m",     "metre",  "metres",  "meter", "meters", "cm",      "mm",  "km",
                                  "ft",    "foot",   "feet",    "in",    "inch",   "inches",  "deg", "degree",
                                  "degrees", "rad",  "radians", "1/m",   "m-1",    "1pm",     "perm", "1/ft",
                                  "1pft",  "perft"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string letters_of(const std::string& text) {
  std::string out;
  const auto kept = [](unsigned char c) { return std::isalnum(c) != 0; };
  std::copy_if(text.begin(), text.end(), std::back_inserter(out), kept);
  return out;
}

bool is_unit(const std::string& text) {
  return std::any_of(std::begin(kUnits), std::end(kUnits), [&](const char* unit) { return text == unit; });
}

/// "X [m]", "x (ft)", "corner_radius_m", "curvature_1pm": name and unit.
std::pair<std::string, std::string> name_and_unit(const std::string& column) {
  const std::string text = lower(column);
  const std::size_t open = text.find_first_of("[(");
  if (open != std::string::npos) {
    const std::size_t close = text.find_first_of("])", open);
    return {letters_of(text.substr(0, open)), text.substr(open + 1, close - open - 1)};
  }
  const std::size_t cut = text.find_last_of("_ ");
  if (cut != std::string::npos && is_unit(text.substr(cut + 1))) {
    std::string name = letters_of(text.substr(0, cut)), unit = text.substr(cut + 1);
    const std::size_t per = text.rfind("per", cut);
    if (per != std::string::npos && per + 3 == cut) {
      name = letters_of(text.substr(0, per));
      unit = "per" + unit;
    }
    return {name, unit};
  }
  return {letters_of(text), ""};
}

struct KnownUnit {
  const char* name;
  double metres;  ///< of a length; of a curvature: metres that the length of its denominator has
};
constexpr KnownUnit kLengths[] = {
    {"m", 1.0},       {"metre", 1.0},  {"metres", 1.0}, {"meter", 1.0},   {"meters", 1.0},  {"cm", 0.01},
    {"mm", 0.001},    {"km", 1000.0},  {"ft", 0.3048},  {"foot", 0.3048}, {"feet", 0.3048}, {"in", 0.0254},
    {"inch", 0.0254}, {"inches", 0.0254}, {"1pm", 1.0}, {"1/m", 1.0},     {"perm", 1.0},    {"m-1", 1.0},
    {"m^-1", 1.0},    {"rad/m", 1.0},  {"1pft", 0.3048}, {"1/ft", 0.3048}, {"perft", 0.3048}, {"rad/ft", 0.3048}};

std::optional<double> metres_in(const std::string& unit) {
  const auto* found = std::find_if(std::begin(kLengths), std::end(kLengths),
                                   [&](const KnownUnit& known) { return unit == known.name; });
  return found == std::end(kLengths) ? std::nullopt : std::optional(found->metres);
}

}  // namespace

SourceColumns::SourceColumns(const SourceTable& table) : table_(table) {
  for (std::size_t k = 0; k < table.names().size(); ++k) {
    auto [name, unit] = name_and_unit(table.names()[k]);
    if (unit.empty()) unit = lower(table.unit(k));
    columns_.push_back({name, unit});
  }
}

std::optional<std::size_t> SourceColumns::find(Quantity quantity) const {
  for (const KnownNames& known : known_names()) {
    if (known.quantity != quantity) continue;
    for (const char* name : known.names) {
      const auto is_it = [&](const Column& column) { return column.name == name; };
      const auto found = std::find_if(columns_.begin(), columns_.end(), is_it);
      if (found != columns_.end()) return static_cast<std::size_t>(found - columns_.begin());
    }
  }
  return std::nullopt;
}

std::string SourceColumns::all_names() const {
  if (table_.names().empty()) return fmt::format("{} columns without names", table_.columns());
  return fmt::format("the columns {}", fmt::join(table_.names(), ", "));
}

std::size_t SourceColumns::at(Quantity quantity) const {
  if (const auto found = find(quantity)) return *found;
  for (const KnownNames& known : known_names()) {
    if (known.quantity != quantity) continue;
    const std::size_t shown = std::min<std::size_t>(3, known.names.size());
    throw InputError(table_.path(), all_names(),
                     fmt::format("a column named {} or alike",
                                 fmt::join(known.names.begin(), known.names.begin() + static_cast<long>(shown), ", ")),
                     "Name the column in the header line");
  }
  return 0;
}

SourceKind SourceColumns::kind() const {
  if (has(Quantity::kType) && has(Quantity::kRadius)) return SourceKind::kSegments;
  if (has(Quantity::kStraight) && has(Quantity::kRadius)) return SourceKind::kSegments;
  if (has(Quantity::kLeftX) && has(Quantity::kRightX)) return SourceKind::kGates;
  if (has(Quantity::kDistance) && has(Quantity::kCurvature)) return SourceKind::kCurvature;
  if (has(Quantity::kLatitude) && has(Quantity::kLongitude)) return SourceKind::kGps;
  if (has(Quantity::kX) && has(Quantity::kY)) return SourceKind::kPoints;
  if (table_.names().empty() && table_.columns() == 2) return SourceKind::kPoints;
  throw InputError(table_.path(), all_names(),
                   "x and y; latitude and longitude; left_x, left_y, right_x and right_y of gates; s and curvature; or "
                   "type, section_length and corner_radius of segments",
                   "Name the columns so in the header line; voltlap track import --help shows examples");
}

double SourceColumns::metres_per_unit(Quantity quantity, std::optional<double> given) const {
  const auto column = find(quantity);
  const std::string unit = column ? columns_[*column].unit : "";
  const std::optional<double> named = metres_in(unit);
  const std::string name = column ? table_.names()[*column] : "column 1";
  if (named && given && *named != *given) {
    throw InputError("--unit", fmt::format("another unit than that of the column {}", name), "one unit",
                     "Leave --unit out, or correct the header line");
  }
  if (named) return *named;
  if (given) return *given;
  throw InputError(fmt::format("{}, {}", table_.path(), name), unit.empty() ? "no unit" : "the unit \"" + unit + '"',
                   "metres or feet", "Say --unit m or --unit ft, or name the column with its unit, as in x_m");
}

double SourceColumns::radians_per_unit() const {
  const std::size_t column = at(Quantity::kAngle);
  const std::string& unit = columns_[column].unit;
  if (unit.starts_with("rad")) return 1.0;
  if (unit.starts_with("deg")) return M_PI / 180.0;
  throw InputError(fmt::format("{}, {}", table_.path(), table_.names()[column]),
                   unit.empty() ? "no unit" : "the unit \"" + unit + '"', "degrees or radians",
                   "Name the column corner_angle_deg or corner_angle_rad");
}

}  // namespace voltlap::plant
