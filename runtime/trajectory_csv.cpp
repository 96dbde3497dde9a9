#include "runtime/trajectory_csv.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "runtime/regular_file.h"

namespace hapton {
namespace {

constexpr std::array<std::string_view, 8> kColumns = {"t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"};
constexpr std::string_view kSampleColumn = ",sample";
constexpr std::string_view kButtonsColumn = ",buttons";
constexpr std::string_view kShortHeader = "t_s,x_m,y_m,z_m";
constexpr std::string_view kLongHeader = "t_s,x_m,y_m,z_m,qw,qx,qy,qz";
constexpr double kQuaternionTolerance = 0.01;                      // of the quaternion's length, whose numbers may have only two digits
constexpr double kFarthestM = 1e6;                                 // io_node's safety governor rejects poses farther out, too
constexpr double kLongestS = 1e9;                                  // 31 years
constexpr std::size_t kMaxTrajectoryBytes = std::size_t{1} << 34;  // a day at 1 kHz; more would take all memory
constexpr int kTimeColumn = 0;
constexpr int kFirstRotationColumn = 4;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

// The file's own text as an error message shows it: short, and without characters that could disturb a terminal.
std::string quoted(std::string_view text) {
  std::string shown(text.substr(0, 40));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return "'" + shown + (text.size() > 40 ? "...'" : "'");
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& name) : rest_(text), name_(name) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
    rows_.reserve(rest_.size() / 48);  // about the bytes of a short row: too few rows only cost a second allocation
  }

  Result<std::vector<TrajectoryRow>> parse() {
    while (const auto line = next_line()) {
      const auto read = columns_ == 0 ? read_header(*line) : read_row(*line);
      if (!read) return tl::unexpected(read.error());
    }
    if (columns_ == 0) return fail("{}: empty; it must begin with the line {}[,qw,qx,qy,qz]", name_, kShortHeader);
    if (rows_.empty()) return fail("{}: a header but no rows; add one row a step", name_);
    return std::move(rows_);
  }

 private:
  // The next line that is neither empty nor a comment.
  std::optional<std::string_view> next_line() {
    while (!rest_.empty()) {
      const auto end = rest_.find('\n');
      const auto line = trimmed(rest_.substr(0, end));
      rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
      ++line_number_;
      if (!line.empty() && line.front() != '#') return line;
    }
    return std::nullopt;
  }

  Result<void> read_header(std::string_view line) {
    has_samples_ = line.ends_with(kSampleColumn);
    std::string_view numbers = has_samples_ ? line.substr(0, line.size() - kSampleColumn.size()) : line;
    has_buttons_ = numbers.ends_with(kButtonsColumn);
    if (has_buttons_) numbers.remove_suffix(kButtonsColumn.size());
    if (numbers == kShortHeader) columns_ = 4;
    if (numbers == kLongHeader) columns_ = 8;
    if (columns_ == 0)
      return fail("{}:{}: the header is {}; write {}[,qw,qx,qy,qz][,buttons][,sample]", name_, line_number_, quoted(line), kShortHeader);
    return {};
  }

  Result<void> read_row(std::string_view line) {
    std::array<double, 8> field = {0, 0, 0, 0, 1, 0, 0, 0};
    std::uint32_t buttons = 0;
    const int columns = columns_ + (has_buttons_ ? 1 : 0) + (has_samples_ ? 1 : 0);
    for (int column = 0; column < columns; ++column) {
      const auto comma = line.find(',');
      if ((comma == std::string_view::npos) != (column == columns - 1))
        return fail("{}:{}: the row has {} fields than the header's {}; give it {}", name_, line_number_,
                    column == columns - 1 ? "more" : "fewer", columns, columns);
      const std::string_view text = trimmed(line.substr(0, comma));
      const bool is_buttons = has_buttons_ && column == columns_;
      const auto read = is_buttons           ? read_buttons(text, buttons)
                        : column >= columns_ ? check_sample(text)
                                             : read_number(text, column, field[column]);
      if (!read) return read;
      line = comma == std::string_view::npos ? std::string_view{} : line.substr(comma + 1);
    }
    return add_row(field, buttons);
  }

  Result<void> check_sample(std::string_view text) const {
    const bool is_count = !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
    if (!is_count) return fail("{}:{}: {} in column sample is not a count; write one like 12", name_, line_number_, quoted(text));
    return {};
  }

  Result<void> read_buttons(std::string_view text, std::uint32_t& buttons) const {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), buttons);
    if (error != std::errc{} || end != text.data() + text.size() || text.empty())
      return fail("{}:{}: {} in column buttons is not a number of 32 bits; write one bit for each button that is down: 0, 1, 2, 3 ...",
                  name_, line_number_, quoted(text));
    return {};
  }

  Result<void> read_number(std::string_view text, int column, double& value) const {
    const std::string_view digits = text.starts_with('+') ? text.substr(1) : text;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || digits.empty() || !std::isfinite(value))
      return fail("{}:{}: {} in column {} is not a finite number; write one like 0.0125", name_, line_number_, quoted(text),
                  kColumns[column]);
    return check_reach(text, column, value);
  }

  Result<void> check_reach(std::string_view text, int column, double value) const {
    if (column == kTimeColumn && std::abs(value) > kLongestS)
      return fail("{}:{}: t_s is {}, more than 30 years; give times in seconds", name_, line_number_, quoted(text));
    if (column != kTimeColumn && column < kFirstRotationColumn && std::abs(value) > kFarthestM)
      return fail("{}:{}: {} is {}, beyond the reach of any device; give positions in metres, within {:.0f} of the origin", name_,
                  line_number_, kColumns[column], quoted(text), kFarthestM);
    return {};
  }

  Result<void> add_row(const std::array<double, 8>& field, std::uint32_t buttons) {
    TrajectoryRow row;
    row.buttons = buttons;
    row.has_turn = columns_ == 8;
    row.t_s = field[0];
    row.p_WD = Vec3(field[1], field[2], field[3]);
    row.q_WT = Quat(field[4], field[5], field[6], field[7]);
    if (!rows_.empty() && row.t_s <= rows_.back().t_s)
      return fail("{}:{}: t_s is {} after {}; times must increase from row to row", name_, line_number_, row.t_s, rows_.back().t_s);
    const double length = row.q_WT.norm();
    if (!(std::abs(length - 1.0) <= kQuaternionTolerance))
      return fail("{}:{}: the quaternion has length {}; give it length 1", name_, line_number_, length);
    row.q_WT.coeffs() /= length;
    rows_.push_back(row);
    return {};
  }

  std::string_view rest_;
  const std::string& name_;
  std::vector<TrajectoryRow> rows_;
  long line_number_ = 0;
  int columns_ = 0;  // columns of time and pose; 0: the header was not read yet
  bool has_buttons_ = false;
  bool has_samples_ = false;
};

}  // namespace

Result<std::vector<TrajectoryRow>> parse_trajectory_csv(std::string_view text, const std::string& name) {
  return Parser(text, name).parse();
}

std::string positions_to_csv(const std::vector<TrajectoryRow>& rows) {
  std::string text = "t_s,x_m,y_m,z_m\n";
  for (const TrajectoryRow& row : rows)
    fmt::format_to(std::back_inserter(text), "{},{},{},{}\n", row.t_s, row.p_WD.x(), row.p_WD.y(), row.p_WD.z());
  return text;
}

Result<std::vector<TrajectoryRow>> read_trajectory_csv(const std::string& path) {
  const auto text = read_regular_file(path, "give the path of a trajectory CSV", kMaxTrajectoryBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_trajectory_csv(*text, path);
}

}  // namespace hapton
