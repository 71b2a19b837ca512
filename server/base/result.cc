#include "server/base/result.h"

#include "server/base/check.h"

namespace kerf {

void wrong_result_access(const char* message) {
  check_failed("Result::ok()", __FILE__, __LINE__, message);
}

}  // namespace kerf
