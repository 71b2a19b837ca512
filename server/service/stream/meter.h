#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kerf::sheet {
class Sheet;
}  // namespace kerf::sheet

namespace kerf::stream {

// Measures a sheet for the frames of one stream. Called on the sheet's strand only.
class Meter {
 public:
  virtual ~Meter() = default;

  // Returns a number for each column. `serial`: sheet::RunStats::sheet_serial of the sheet.
  virtual std::vector<double> measure(const sheet::Sheet& sheet, std::uint64_t serial) = 0;
  // Returns the names of the columns; callable from any thread.
  [[nodiscard]] virtual const std::vector<std::string>& columns() const = 0;
};

}  // namespace kerf::stream
