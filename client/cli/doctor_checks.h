#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// Checks of this machine, one finding each. They change nothing.
namespace kerf::cli {

enum class Level { kOk, kWarning, kProblem };
[[nodiscard]] const char* name_of(Level level);  // "ok", "warning", "problem"

struct Finding {
  Level level = Level::kOk;
  std::string name;    // The thing examined, such as "processors".
  std::string text;    // Its state.
  std::string advice;  // Empty if nothing is to be done.
};

[[nodiscard]] Finding check_processors(std::int32_t count);
// `bytes`: memory that a process may use here; 0 if unknown.
[[nodiscard]] Finding check_memory(std::int64_t bytes);
// `most`: the largest number of files and connections that kerfd can have open here.
[[nodiscard]] Finding check_open_files(std::int64_t most);
// `folder`: the data folder of kerfd, which need not be there yet.
[[nodiscard]] Finding check_data_folder(const std::string& folder);
// `option` names the file for the reader. The first certificate counts; `now_s`: seconds since 1970.
[[nodiscard]] Finding check_certificate(const std::string& option, const std::string& file, std::int64_t now_s);
[[nodiscard]] Finding check_token_file(const std::string& file);
// `address`: HOST:PORT at which kerfd would listen. `taken_by_kerf`: a Kerf server answered there.
[[nodiscard]] Finding check_port(const std::string& name, const std::string& address, bool taken_by_kerf);
// `program`: the path of kerfd. `version`: that of this command. Also reports the devices that draw pictures.
[[nodiscard]] std::vector<Finding> check_server_program(const std::string& program, const std::string& version);

// Returns the path of kerfd: beside this program, else from PATH; empty if there is none.
[[nodiscard]] std::string find_server_program();
// Returns the folder in which kerfd keeps its sheets by default; empty if it is unknown.
[[nodiscard]] std::string default_data_folder();

}  // namespace kerf::cli
