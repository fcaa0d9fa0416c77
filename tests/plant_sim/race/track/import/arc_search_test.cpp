// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/arc_search.hpp"

#include <fmt/format.h>

#include <cmath>
#include <random>

#include "race/track/import/arc_pieces.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

struct Drawn {
  explicit Drawn(unsigned seed) : engine(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  std::mt19937_64 engine;
};

PlanePoint beside(const Arc& arc, const PlanePose& from, double along_m, double offset_m) {
  const PlanePose there = end_of({along_m, arc.curvature_per_m}, from);
  return there.at + offset_m * left_of(there.ahead());
}

/// Straight, corner, straight, corner the other way, straight; exact points each quarter of a metre.
const std::vector<Arc> kChicane = {{20.0, 0.0, true}, {9.0, 0.15}, {6.0, 0.0, true}, {12.0, -0.1}, {25.0, 0.0, true}};

/// The same places as arcs of a metre that know no straights, with points beside them.
ArcCourse in_short_arcs(const std::vector<Arc>& arcs, std::vector<WeightedPoint>& points) {
  ArcCourse course{{}, {{3.0, -2.0}, 0.7}, false, 0.01};
  for (const Arc& arc : arcs) {
    const int pieces = static_cast<int>(arc.length_m);
    for (int k = 0; k < pieces; ++k) {
      const Arc piece{arc.length_m / pieces, arc.curvature_per_m};
      PlacedArc placed{piece, course.end, {}};
      for (const double along : {0.1, 0.35, 0.6, 0.85}) {
        placed.points.push_back(points.size());
        points.push_back({beside(piece, course.end, along, 0.0), 1.0});
      }
      course.arcs.push_back(placed);
      course.end = end_of(piece, course.end);
    }
  }
  return course;
}

}  // namespace

TEST_GROUP(ArcSearch){};

TEST(ArcSearch, TheFootOfAPointBesideAnArcIsWhereItWasPlaced) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Drawn draw(seed);
    const double curvature = seed % 5 == 0 ? 0.0 : draw.between(-0.3, 0.3);
    const Arc arc{draw.between(1.0, 15.0), curvature};
    const PlanePose from{{draw.between(-500.0, 500.0), draw.between(-500.0, 500.0)}, draw.between(-7.0, 7.0)};
    const double along = draw.between(0.0, 1.0) * arc.length_m, offset = draw.between(-2.0, 2.0);
    const Foot foot = foot_of(beside(arc, from, along, offset), arc, from, from.ahead());
    const std::string which = fmt::format("seed {}", seed);
    DOUBLES_EQUAL_TEXT(along, foot.along_m, 1e-9, which.c_str());
    DOUBLES_EQUAL_TEXT(offset, foot.offset_m, 1e-9, which.c_str());
  }
}

TEST(ArcSearch, ExactPointsOfAChicaneGiveItsStraightsAndCorners) {
  std::vector<WeightedPoint> points;
  const ArcCourse start = in_short_arcs(kChicane, points);
  const ArcCourse found = search_arcs(start, points, {});
  LONGS_EQUAL(kChicane.size(), found.arcs.size());
  for (std::size_t k = 0; k < kChicane.size(); ++k) {
    DOUBLES_EQUAL(kChicane[k].length_m, found.arcs[k].arc.length_m, 0.05);
    DOUBLES_EQUAL(kChicane[k].curvature_per_m, found.arcs[k].arc.curvature_per_m, 1e-3);
    CHECK_EQUAL(kChicane[k].straight, found.arcs[k].arc.straight);
  }
}

TEST(ArcSearch, EachArcBeginsWhereAndAsTheOneBeforeEnds) {
  std::vector<WeightedPoint> points;
  const ArcCourse start = in_short_arcs(kChicane, points);
  const ArcCourse found = search_arcs(start, points, {});
  for (std::size_t k = 0; k < found.arcs.size(); ++k) {
    const PlanePose end = end_of(found.arcs[k].arc, found.arcs[k].from);
    const PlanePose next = k + 1 < found.arcs.size() ? found.arcs[k + 1].from : found.end;
    DOUBLES_EQUAL(0.0, length(end.at - next.at), 1e-3);
    DOUBLES_EQUAL(0.0, std::remainder(end.heading_rad - next.heading_rad, 2.0 * M_PI), 1e-3);
  }
}

TEST(ArcSearch, AChainWhoseEndsCannotMeetIsSaidNotToMeet) {
  ArcChain chain{{{{10.0, 0.0, true}, {}, {}}}, {{10.0, 3.0}, 0.0}};  // one straight does not get there
  chain.start_held = chain.end_held = true;
  const std::optional<ChainFit> fit = fit_chain(chain, {}, 0.01);
  CHECK(!fit || !fit->meets);
}

TEST(ArcSearch, PointsAreCutWhereOneStraightOrCircleEnds) {
  std::vector<WeightedPoint> points;
  const ArcCourse course = in_short_arcs(kChicane, points);
  const std::vector<PointPiece> pieces = cut_into_pieces(points, false, 0.001);
  LONGS_EQUAL(kChicane.size(), pieces.size());
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    CHECK_EQUAL(kChicane[k].straight, pieces[k].straight);
    DOUBLES_EQUAL(kChicane[k].curvature_per_m, pieces[k].curve.curvature_per_m(), 1e-6);
  }
}
