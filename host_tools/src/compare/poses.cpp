#include "compare/poses.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "csv.h"

namespace host {
namespace {

constexpr std::int64_t most_seconds = 4600000000;  // as of CsvReader::stamp
constexpr const char* asl_columns = "timestamp [ns], p_x, p_y, p_z [m], q_w, q_x, q_y, q_z (, more)";
constexpr const char* tum_columns = "timestamp [s] x y z [m] qx qy qz qw";

[[noreturn]] void fail_line(const std::filesystem::path& file, std::size_t line, const std::string& expected) {
  throw InputError(file.string() + ":" + std::to_string(line) + ": expected " + expected);
}

/// Appends a pose after checks; the quaternion is brought to unit length.
void append(Poses& poses, Pose pose, const std::filesystem::path& file, std::size_t line) {
  const double norm = pose.q_GI.norm();
  if (!(std::abs(norm - 1) < 0.01)) fail_line(file, line, "a quaternion of unit length");
  if (!pose.p_GI.allFinite()) fail_line(file, line, "a finite position");
  if (!poses.empty() && pose.t_ns <= poses.back().t_ns) fail_line(file, line, "a stamp after the one before");
  pose.q_GI.normalize();
  poses.push_back(pose);
}

/// Decimal seconds to ns without the rounding of a double, which holds no nanoseconds of the years since 1970.
bool stamp_from_seconds(std::string_view text, std::int64_t* t_ns) {
  const std::size_t dot = text.find('.');
  const std::string_view whole = text.substr(0, dot);
  if (text.find_first_of("eE") != std::string_view::npos) {
    double seconds = 0;
    const auto r = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (r.ec != std::errc() || r.ptr != text.data() + text.size() ||
        !(std::abs(seconds) < static_cast<double>(most_seconds)))
      return false;
    *t_ns = std::llround(seconds * 1e9);
    return true;
  }
  std::int64_t seconds = 0, ns = 0;
  const auto r = std::from_chars(whole.data(), whole.data() + whole.size(), seconds);
  if (r.ec != std::errc() || r.ptr != whole.data() + whole.size() || seconds < -most_seconds || seconds > most_seconds)
    return false;
  std::string digits(dot == std::string_view::npos ? "" : text.substr(dot + 1));
  if (digits.find_first_not_of("0123456789") != std::string::npos) return false;
  digits.resize(9, '0');
  std::from_chars(digits.data(), digits.data() + 9, ns);
  *t_ns = seconds * 1000000000 + (whole.front() == '-' ? -ns : ns);
  return true;
}

std::vector<std::string_view> words_of(std::string_view row) {
  std::vector<std::string_view> out;
  constexpr std::string_view blanks = " \t\r";
  for (std::size_t begin; (begin = row.find_first_not_of(blanks)) != std::string_view::npos;) {
    const std::size_t end = std::min(row.find_first_of(blanks, begin), row.size());
    out.push_back(row.substr(begin, end - begin));
    row.remove_prefix(end);
  }
  return out;
}

bool parse_tum_row(const std::vector<std::string_view>& words, Pose* pose) {
  double v[7];
  if (words.size() != 8 || !stamp_from_seconds(words[0], &pose->t_ns)) return false;
  for (std::size_t i = 0; i < 7; ++i) {
    const char* const end = words[i + 1].data() + words[i + 1].size();
    const auto r = std::from_chars(words[i + 1].data(), end, v[i]);
    if (r.ec != std::errc() || r.ptr != end) return false;
  }
  pose->p_GI = {v[0], v[1], v[2]};
  pose->q_GI = Eigen::Quaterniond(v[6], v[3], v[4], v[5]);
  return true;
}

Poses read_asl(const std::filesystem::path& file) {
  Poses poses;
  CsvReader csv(file, asl_columns, 8, 64);
  while (csv.next_row()) {
    Pose pose;
    pose.t_ns = csv.stamp(0);
    pose.p_GI = {csv.number(1), csv.number(2), csv.number(3)};
    pose.q_GI = Eigen::Quaterniond(csv.number(4), csv.number(5), csv.number(6), csv.number(7));
    append(poses, pose, file, csv.line());
  }
  return poses;
}

}  // namespace

Poses read_tum(const std::filesystem::path& file) {
  const std::string content = read_file(file);
  Poses poses;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < content.size();) {
    const std::size_t end = std::min(content.find('\n', begin), content.size());
    const std::string_view row(content.data() + begin, end - begin);
    begin = end + 1;
    ++line;
    const std::vector<std::string_view> words = words_of(row);
    if (words.empty() || words[0].front() == '#') continue;
    Pose pose;
    if (!parse_tum_row(words, &pose)) fail_line(file, line, tum_columns);
    append(poses, pose, file, line);
  }
  if (poses.empty()) fail_line(file, line, std::string("at least one row of ") + tum_columns);
  return poses;
}

Poses read_poses(const std::filesystem::path& file) {
  return file.extension() == ".csv" ? read_asl(file) : read_tum(file);
}

Poses poses_of(const std::vector<CoreState>& trajectory) {
  Poses out;
  for (const CoreState& s : trajectory) {
    if (!out.empty() && s.t_ns <= out.back().t_ns) continue;
    const Eigen::Vector4d& q = s.q_GI_wxyz;
    out.push_back({s.t_ns, s.p_GI, Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized()});
  }
  return out;
}

Poses poses_of(const std::vector<TruthPose>& truth) {
  Poses out;
  for (const TruthPose& s : truth) {
    if (!out.empty() && s.t_ns <= out.back().t_ns) continue;
    const auto& q = s.q_GI_wxyz;
    out.push_back({s.t_ns, {s.p_GI[0], s.p_GI[1], s.p_GI[2]}, Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized()});
  }
  return out;
}

bool pose_at(const Poses& poses, std::int64_t t_ns, double largest_gap_s, Pose* out) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), t_ns, [](const Pose& p, std::int64_t t) { return p.t_ns < t; });
  if (after == poses.end()) return false;
  if (after->t_ns == t_ns) {
    *out = *after;
    return true;
  }
  if (after == poses.begin()) return false;
  const Pose& before = *(after - 1);
  const double gap = static_cast<double>(after->t_ns - before.t_ns);
  if (gap > largest_gap_s * 1e9) return false;
  const double share = static_cast<double>(t_ns - before.t_ns) / gap;
  *out = {t_ns, (1 - share) * before.p_GI + share * after->p_GI, before.q_GI.slerp(share, after->q_GI)};
  return true;
}

}  // namespace host
