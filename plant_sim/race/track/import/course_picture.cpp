// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "race/track/import/smooth_path.hpp"
#include "race/track/outline.hpp"

namespace voltlap::plant {
namespace {

constexpr double kWidth_px = 1000.0, kMargin_px = 40.0, kLegend_px = 90.0;
constexpr double kStep_m = 1.0;

struct RadiusColour {
  double below_m;
  const char *colour, *words;
};
constexpr std::array<RadiusColour, 4> kColours = {{{8.0, "#b2182b", "radius below 8 m"},
                                                   {20.0, "#ef8a62", "8 to 20 m"},
                                                   {100.0, "#67a9cf", "20 to 100 m"},
                                                   {1e300, "#2f4b5c", "straight (100 m and more)"}}};

const char* colour_of(double curvature) {
  const double radius = 1.0 / std::max(1e-9, std::abs(curvature));
  return std::find_if(kColours.begin(), kColours.end(), [&](const RadiusColour& c) { return radius < c.below_m; })
      ->colour;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '&') out += "&amp;";
    else out += c;
  }
  return out;
}

/// Metres to picture: both axes alike, y upwards.
class Frame {
 public:
  explicit Frame(const PointList& a, const PointList& b) {
    for (const PointList* points : {&a, &b}) {
      for (const PlanePoint& p : *points) {
        low_ = {std::min(low_.x_m, p.x_m), std::min(low_.y_m, p.y_m)};
        high_ = {std::max(high_.x_m, p.x_m), std::max(high_.y_m, p.y_m)};
      }
    }
    const double extent = std::max({1.0, high_.x_m - low_.x_m, high_.y_m - low_.y_m});
    scale_ = (kWidth_px - 2.0 * kMargin_px) / extent;
  }
  [[nodiscard]] double x(PlanePoint p) const { return kMargin_px + scale_ * (p.x_m - low_.x_m); }
  [[nodiscard]] double y(PlanePoint p) const { return kMargin_px + scale_ * (high_.y_m - p.y_m); }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double width() const { return std::max(700.0, 2.0 * kMargin_px + scale_ * (high_.x_m - low_.x_m)); }
  [[nodiscard]] double height() const { return 2.0 * kMargin_px + kLegend_px + scale_ * (high_.y_m - low_.y_m); }

 private:
  PlanePoint low_{1e300, 1e300}, high_{-1e300, -1e300};
  double scale_ = 1.0;
};

std::string legend(const Frame& frame, const std::string& caption) {
  const double base = frame.height() - kLegend_px + 10.0;
  std::string text = fmt::format("<text x='{}' y='{:.0f}'>{}</text>\n", kMargin_px, base, escaped(caption));
  double at = kMargin_px;
  for (const RadiusColour& c : kColours) {
    text += fmt::format("<rect x='{0:.0f}' y='{1:.0f}' width='18' height='6' fill='{2}'/>", at, base + 18.0, c.colour);
    text += fmt::format("<text x='{:.0f}' y='{:.0f}'>{}</text>\n", at + 24.0, base + 26.0, c.words);
    at += 150.0;
  }
  double bar_m = 1.0;
  for (const double size : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 5000.0}) {
    if (size * frame.scale() < 200.0) bar_m = size;
  }
  const double bar_px = bar_m * frame.scale();
  text += fmt::format("<path d='M{:.1f} {:.1f}h{:.1f}' stroke='black' stroke-width='2'/>", kMargin_px, base + 46.0,
                      bar_px);
  return text + fmt::format("<text x='{:.1f}' y='{:.1f}'>{:g} m</text>\n", kMargin_px + bar_px + 8.0, base + 50.0,
                            bar_m);
}

/// Curvature at each of `n` points that lie evenly along the course.
std::vector<double> curvatures_along(const Track& track, std::size_t n) {
  std::vector<double> out;
  const double length = track.length_m();
  std::size_t k = 0;
  double end = track.segments[0].length_m;
  for (std::size_t i = 0; i < n; ++i) {
    const double at = length * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    while (at > end && k + 1 < track.segments.size()) end += track.segments[++k].length_m;
    out.push_back(track.segments[k].curvature_per_m);
  }
  return out;
}

}  // namespace

std::string course_picture(const Track& track, const PointList& line, const PointList& points,
                           const std::string& caption) {
  PointList shape = line;
  if (shape.empty()) {
    for (const OutlinePoint& p : outline(track, kStep_m)) shape.push_back({p.x_m, p.y_m});
  }
  VOLTLAP_DEMAND(shape.size() >= 2);
  const Frame frame(shape, points);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.0f}' height='{1:.0f}' viewBox='0 0 {0:.0f} {1:.0f}' "
      "font-family='sans-serif' font-size='13'>\n<title>{2}</title>\n<rect width='100%' height='100%' fill='white'/>\n",
      frame.width(), frame.height(), escaped(track.name));
  for (const PlanePoint& p : points) {
    svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='1.5' fill='#bbbbbb'/>\n", frame.x(p), frame.y(p));
  }
  const std::vector<double> curvature = curvatures_along(track, shape.size() - 1);
  for (std::size_t i = 0; i + 1 < shape.size();) {
    const char* colour = colour_of(curvature[i]);
    std::string path = fmt::format("M{:.1f} {:.1f}", frame.x(shape[i]), frame.y(shape[i]));
    for (; i + 1 < shape.size() && colour_of(curvature[i]) == colour; ++i) {
      path += fmt::format("L{:.1f} {:.1f}", frame.x(shape[i + 1]), frame.y(shape[i + 1]));
    }
    svg += fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='3'/>\n", path, colour);
  }
  const std::size_t ahead = std::min<std::size_t>(shape.size() - 1, 8);
  const PlanePoint way = shape[ahead] - shape[0];
  const double angle = -std::atan2(way.y_m, way.x_m) * 180.0 / M_PI;
  svg += fmt::format("<path d='M0 -9L18 0L0 9Z' fill='#1a7a1a' transform='translate({:.1f} {:.1f}) rotate({:.1f})'/>\n",
                     frame.x(shape[0]), frame.y(shape[0]), angle);
  return svg + legend(frame, caption) + "</svg>\n";
}

}  // namespace voltlap::plant
