#include "client/cli/tables.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "client/cli/output.h"

namespace kerf::cli {
namespace {

std::string to_csv(const v1::Table& table) {
  std::string text;
  for (int i = 0; i < table.columns_size(); ++i) text += (i > 0 ? "," : "") + table.columns(i);
  text += "\n";
  for (const v1::Table::Row& row : table.rows()) {
    for (int i = 0; i < row.values_size(); ++i) {
      char number[32];
      std::snprintf(number, sizeof number, "%s%.17g", i > 0 ? "," : "", row.values(i));
      text += number;
    }
    text += "\n";
  }
  return text;
}

// Returns a line about the time-dependent influences that were left out.
std::string left_out(const v1::StaticResult& statics) {
  std::string line;
  for (int i = 0; i < statics.left_out_size(); ++i) line += (i == 0 ? "\n  left out: " : ", ") + statics.left_out(i);
  return line;
}

}  // namespace

std::string excerpt(const v1::Table& table) {
  constexpr int kShown = 12;
  std::string text = "\n  " + table.name() + ":";
  const int columns = std::min(table.columns_size(), 6);
  const auto line = [&](const auto& cell) {
    text += "\n   ";
    for (int i = 0; i < columns; ++i) text += " " + cell(i);
    if (columns < table.columns_size()) text += " ...";
  };
  line([&](int i) {
    std::string name = table.columns(i);
    if (name.size() < 14) name.insert(0, 14 - name.size(), ' ');
    return name;
  });
  for (int r = 0; r < table.rows_size(); ++r) {
    if (r == kShown && r + 1 < table.rows_size()) {
      text +=
          "\n    ... " + std::to_string(table.rows_size() - kShown - 1) + " more; --csv and --out write all of them";
      r = table.rows_size() - 1;
    }
    line([&](int i) {
      char number[32];
      const auto width = static_cast<int>(std::max<std::size_t>(14, table.columns(i).size()));
      std::snprintf(number, sizeof number, "%*.6g", width, table.rows(r).values(i));
      return std::string(number);
    });
  }
  return text;
}

Status write_csv(Disk& disk, const std::string& folder, const google::protobuf::RepeatedPtrField<v1::Table>& tables) {
  if (folder.empty()) return Nothing{};
  for (const v1::Table& table : tables) {
    const std::string file = (std::filesystem::path(folder) / (table.name() + ".csv")).string();
    KERF_TRY(disk.write_file(file, to_csv(table)));
  }
  return Nothing{};
}

std::string describe(const v1::StaticResult& statics) {
  char text[256];
  if (!statics.converged() && statics.load() == 0.0) {
    std::snprintf(text, sizeof text, "no equilibrium, %lld Newton steps in %lld solves",
                  static_cast<long long>(statics.newton_iterations()), static_cast<long long>(statics.solves()));
    return text + left_out(statics);
  }
  std::snprintf(text, sizeof text, "equilibrium at load %.6g%s, residual %.1e, %lld Newton steps in %lld solves",
                statics.load(), statics.stable() ? "" : " (unstable)", statics.residual(),
                static_cast<long long>(statics.newton_iterations()), static_cast<long long>(statics.solves()));
  return text + left_out(statics);
}

std::string describe(const v1::DynamicResult& dynamics) {
  char text[256];
  std::snprintf(text, sizeof text,
                "%lld ticks, %.6g s: kinetic %.4g J, membrane %.4g J, bending %.4g J, gravity %.4g J; state hash %s",
                static_cast<long long>(dynamics.ticks()), dynamics.simulated_s(), dynamics.energies().kinetic_j(),
                dynamics.energies().membrane_j(), dynamics.energies().bending_j(), dynamics.energies().gravity_j(),
                dynamics.state_hash().c_str());
  return text + describe_flags(dynamics.flagged_ticks());
}

std::string describe_flags(const google::protobuf::Map<std::string, std::int64_t>& flagged_ticks) {
  std::string text;
  for (const auto& [flag, ticks] : by_name(flagged_ticks)) {
    text += "\n  " + flag + " in " + std::to_string(ticks) + " ticks";
  }
  return text;
}

int check_converged(const v1::StaticResult& statics) {
  if (statics.converged()) return kDone;
  std::array<char, 32> load{};
  std::snprintf(load.data(), load.size(), "%.6g", statics.load());
  const std::string why =
      statics.reason().empty()
          ? "; the results hold the states up to it. More steps, more max_iterations, or an imperfection where "
            "a sheet buckles may help"
          : ": " + statics.reason();
  return refuse(
      failed_precondition("NO_EQUILIBRIUM", std::string("no equilibrium was found beyond load ") + load.data() + why));
}

}  // namespace kerf::cli
