#include "server/service/api/paging.h"

#include <string>

namespace kerf::api {

Result<std::size_t> page_size(std::int32_t requested) {
  if (requested >= 0 && requested <= 1000) return static_cast<std::size_t>(requested == 0 ? 100 : requested);
  return invalid_argument(
      "OUT_OF_RANGE", "page_size is " + std::to_string(requested) + "; must be 1 to 1000, or 0 for 100", "page_size");
}

Error bad_page_token() {
  return invalid_argument("PAGE_TOKEN", "page_token was not issued by this server; start with an empty one",
                          "page_token");
}

}  // namespace kerf::api
