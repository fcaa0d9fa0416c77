// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "discrepancy/discount.hpp"
#include "discrepancy/member_effect.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Group's information on its shapes and each member's score, discounted by the natural spread of the members.
struct Discounted {
  MatrixXd information, score;
};

Discounted discounted(const GroupScore& group, const Usual& usual, std::size_t g) {
  const Discount discount(group.gram, usual.group_variance[g]);
  const double weight = 1.0 / usual.group_inflation[g];
  return {weight * discount.information(), weight * discount.score(group.score - group.gram * usual.group_mean[g])};
}

/// Shapes of a form in a group, in the order of its linear parameters.
std::vector<Index> shapes_of(const Design& design, std::size_t g, int cause, std::size_t form) {
  std::vector<Index> out;
  for (std::size_t k = 0; k < design.shapes[g].size(); ++k) {
    if (design.shapes[g][k].cause == cause && design.shapes[g][k].form == form) out.push_back(static_cast<Index>(k));
  }
  return out;
}

/// What the shapes gain at a member; nothing with a size whose sign it cannot have.
double gain_at(const Discounted& d, const std::vector<Index>& shapes, const std::vector<int>& signs, Index member) {
  const auto k = static_cast<Index>(shapes.size());
  MatrixXd a(k, k);
  VectorXd s(k);
  for (Index i = 0; i < k; ++i) {
    s(i) = d.score(shapes[static_cast<std::size_t>(i)], member);
    for (Index j = 0; j < k; ++j) {
      a(i, j) = d.information(shapes[static_cast<std::size_t>(i)], shapes[static_cast<std::size_t>(j)]);
    }
    a(i, i) += 1e-9;
  }
  const VectorXd sizes = a.ldlt().solve(s);
  for (Index i = 0; i < k; ++i) {
    if (sizes(i) * signs[static_cast<std::size_t>(i)] < 0.0) return 0.0;
  }
  return s.dot(sizes);
}

/// Columns of one form of a cause, or shapes of one kind in one channel.
bool same_candidate(const Column& a, const Column& b) {
  if (a.cause != b.cause) return false;
  if (a.cause >= 0) return a.form == b.form;
  for (std::size_t c = 0; c < a.effect.size(); ++c) {
    if ((a.effect[c].size() > 0) != (b.effect[c].size() > 0)) return false;
  }
  return a.kin == b.kin;
}

/// Three typical sizes of a cause; of a shape without a name five times what is usual.
VectorXd prior_variances(const Design& design) {
  constexpr double kTypical = 3.0, kUnusual = 5.0;
  VectorXd out(static_cast<Index>(design.columns.size()));
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    const double size = column.cause >= 0 ? kTypical : kUnusual * column.usual;
    out(static_cast<Index>(k)) = size * size;
  }
  return out;
}

/// What acts between two sensors, as a contact, needs no model of the cells.
bool acts_on_all_cells(const Design& design, const Column& column) {
  if (column.balance != Balance::kVoltage && column.balance != Balance::kCharge) return false;
  for (std::size_t c = 0; c < column.effect.size(); ++c) {
    if ((c == 0 || design.comparison.channels[c].name == "soc") && column.effect[c].size() > 0) return true;
  }
  return false;
}

void append_column(Design& design, const Cause& cause, const Form& form, Candidate& local, std::size_t k) {
  const auto g = static_cast<std::size_t>(local.group);
  const Group& group = design.comparison.groups[g];
  const Shape& shape = design.shapes[g][static_cast<std::size_t>(local.shapes[k])];
  Column column;
  column.cause = local.cause;
  column.form = local.form;
  column.parameter = local.parameters[k];
  column.key = fmt::format("local/{}/{}/{}", cause.name, local.form, k);
  column.balance = cause.balance;
  column.effect = member_effect(design.model, design.comparison, design.base, group, shape.effect, local.members.size(),
                                form.of_sensor);
  local.rows.push_back(static_cast<Index>(design.columns.size()));
  design.columns.push_back(std::move(column));
}

}  // namespace

std::vector<GroupScore> group_scores(const Design& design, const NoiseModel& noise) {
  Design groups_only;
  groups_only.comparison.log.time_s = design.comparison.log.time_s;
  groups_only.comparison.groups = design.comparison.groups;
  groups_only.shapes = design.shapes;
  return score_of(groups_only, noise).groups;
}

std::vector<Candidate> local_candidates(Design& design, const std::vector<Cause>& causes,
                                        const std::vector<GroupScore>& scores, const Usual& usual) {
  std::vector<Candidate> out;
  for (std::size_t g = 0; g < design.comparison.groups.size(); ++g) {
    const Group& group = design.comparison.groups[g];
    const Discounted d = discounted(scores[g], usual, g);
    const auto members = static_cast<Index>(group.members.size());
    for (std::size_t cause = 0; cause < causes.size(); ++cause) {
      for (std::size_t form = 0; form < design.forms[cause].size(); ++form) {
        const Form& f = design.forms[cause][form];
        if (f.apply || f.stem != group.stem) continue;
        Candidate local;
        local.cause = static_cast<int>(cause);
        local.form = form;
        local.balance = causes[cause].balance;
        local.parameters = f.linear;
        local.group = static_cast<int>(g);
        local.shapes = shapes_of(design, g, static_cast<int>(cause), form);
        local.trials = static_cast<double>(members);
        if (local.shapes.size() != f.linear.size()) continue;
        if (f.channel == "ends") {
          local.members = {0, members - 1};
          local.trials = 1.0;
        } else {
          std::vector<int> signs;
          for (const std::size_t p : local.parameters) signs.push_back(sign_of(causes[cause].parameters[p]));
          Index best = 0;
          for (Index i = 1; i < members; ++i) {
            if (gain_at(d, local.shapes, signs, i) > gain_at(d, local.shapes, signs, best)) best = i;
          }
          local.members = {best};
          local.channel = group.members[static_cast<std::size_t>(best)];
        }
        for (std::size_t k = 0; k < local.shapes.size(); ++k) append_column(design, causes[cause], f, local, k);
        out.push_back(std::move(local));
      }
    }
  }
  return out;
}

System system_of(const Design& design, const std::vector<Candidate>& locals, const Score& score, const Usual& usual,
                 const std::vector<Cause>& causes, const std::vector<bool>& use) {
  // What a member differs by from day to day it differs by in the mean of its group too.
  Usual with_members = usual;
  for (const Candidate& local : locals) {
    const MatrixXd& theirs = usual.group_variance[static_cast<std::size_t>(local.group)];
    for (std::size_t i = 0; i < local.rows.size(); ++i) {
      with_members.variance(local.rows[i], local.rows[i]) += theirs(local.shapes[i], local.shapes[i]);
    }
  }
  const Remaining rest = remaining(score.sum(usual.inflation, use), with_members);
  System out{{}, rest.information, rest.score, prior_variances(design), {}};
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    if (column.key.starts_with("local/") || column.free > 0.0) continue;
    const bool goes_on = !out.candidates.empty() && same_candidate(design.columns[k - 1], column);
    if (!goes_on) {
      Candidate made;
      made.cause = column.cause;
      made.form = column.form;
      made.balance = column.balance;
      if (column.cause >= 0) {
        const auto& forms = design.forms[static_cast<std::size_t>(column.cause)];
        made.channel = forms[column.form].channel;
        made.trials = static_cast<double>(forms.size());
      }
      out.candidates.push_back(std::move(made));
    }
    out.candidates.back().of_all_cells = out.candidates.back().of_all_cells || acts_on_all_cells(design, column);
    out.candidates.back().parameters.push_back(column.parameter);
    out.candidates.back().rows.push_back(static_cast<Index>(k));
  }
  const double share = use.empty() ? 1.0
                                   : static_cast<double>(std::count(use.begin(), use.end(), true)) /
                                         static_cast<double>(std::max<std::size_t>(1, use.size()));
  std::vector<Discounted> groups;
  for (std::size_t g = 0; g < score.groups.size(); ++g) {
    groups.push_back(discounted(score.groups[g], usual, g));
  }
  for (const Candidate& a : locals) {
    const auto g = static_cast<std::size_t>(a.group);
    const auto n = static_cast<double>(design.comparison.groups[g].members.size());
    for (std::size_t i = 0; i < a.rows.size(); ++i) {
      for (const Index member : a.members) out.score(a.rows[i]) += share * groups[g].score(a.shapes[i], member);
      for (const Candidate& b : locals) {
        if (b.group != a.group) continue;
        double common = 0.0;
        for (const Index member : a.members) {
          common += static_cast<double>(std::count(b.members.begin(), b.members.end(), member));
        }
        common -= static_cast<double>(a.members.size() * b.members.size()) / n;
        for (std::size_t j = 0; j < b.rows.size(); ++j) {
          out.information(a.rows[i], b.rows[j]) += share * common * groups[g].information(a.shapes[i], b.shapes[j]);
        }
      }
    }
    out.candidates.push_back(a);
  }
  for (Candidate& c : out.candidates) {
    if (c.cause < 0) continue;
    for (const std::size_t parameter : c.parameters) {
      c.signs.push_back(sign_of(causes[static_cast<std::size_t>(c.cause)].parameters[parameter]));
    }
  }
  return out;
}

}  // namespace voltlap::plant
