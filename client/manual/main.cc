// Writes the manual pages from the tables that parse the command lines: `kerf_manual kerf` or `kerf_manual kerfd`.

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "client/cli/app.h"
#include "client/cli/manual.h"
#include "server/app/config.h"

namespace {

kerf::cli::ManualText text_of_kerf() {
  return {
      "kerf",
      "cut, watch and run elastic sheets",
      "kerf is the command line of Kerf, a real-time server for thin elastic sheets that are cut while they move. "
      "Most\n"
      "commands ask a running kerfd(1); run and replay need none. Lengths are metres in material coordinates: a grid\n"
      "spans (0,0) to (width,height), y up.\n"
      "\n"
      "The options below may stand before the command or after it.",
      {{"EXIT STATUS",
        "0: done, a cut that misses the sheet included. 1: refused, with the reason on standard error. 2: wrong "
        "usage.\n"
        "kerf load --fail-if: 3: a condition holds. 4: none holds, and one has too few values. kerf doctor: 3: there "
        "is "
        "a problem.\n"
        "With --json the reason of 1 and 2 is one line of JSON on standard error:\n"
        " {\"error\": {\"code\": \"NOT_FOUND\", \"reason\": \"SHEET_NOT_FOUND\", \"message\": \"...\", \"field\": "
        "\"name\"}}\n"
        "The code is that of gRPC, INVALID_ARGUMENT for wrong usage; the reason is for programs; the field may be "
        "empty."},
       {"ENVIRONMENT",
        "KERF_SERVER: the server's address where --server is not given.\n"
        "KERF_TOKEN_FILE, KERF_TLS_CA, KERF_TLS_CERT, KERF_TLS_KEY: the files where --token-file, --tls-ca, "
        "--tls-cert\n"
        "and --tls-key are not given.\n"
        "KERF_VIEWER: the viewer's address for kerf open, where --viewer is not given."},
       {"EXAMPLES",
        " kerf sheet create flag --grid 60x40 --size 1.5x1 --pin corners --material silk\n"
        " kerf cut flag --bezier \"0.2,0.5 0.4,0.8 0.6,0.2 0.8,0.5\"\n"
        " kerf undo flag && kerf redo flag\n"
        " kerf watch flag\n"
        " kerf run scene.json --ticks 600 --out result.json\n"
        " source <(kerf completion bash)"},
       {"SEE ALSO", "kerfd(1)"}}};
}

kerf::cli::ManualText text_of_kerfd() {
  return {"kerfd",
          "real-time server for elastic sheets that are cut while they move",
          "kerfd steps sheets at a fixed tick, cuts them along curves on request, and streams the result to "
          "viewers.\n"
          "It serves gRPC, and on a second port the viewer, a WebSocket, and every unary call as JSON over POST.\n"
          "\n"
          "When it is ready it prints one line on standard output:\n"
          " {\"grpc\":\"HOST:PORT\",\"http\":\"http://HOST:PORT\"}\n"
          "SIGTERM and SIGINT stop it cleanly, within ten seconds.",
          {{"EXIT STATUS", "0: stopped by a signal. 2: the command line, a scene or an address was refused."},
           {"EXAMPLES",
            " kerfd --scene demo.json\n"
            " kerfd --listen 127.0.0.1:0 --http 127.0.0.1:0 --no-render"},
           {"SEE ALSO", "kerf(1)"}}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view program = argc == 2 ? argv[1] : "";
  if (program == "kerf") {
    kerf::cli::Session session;
    std::fputs(kerf::cli::manual_page(*kerf::cli::make_app(session), text_of_kerf(), KERF_VERSION).c_str(), stdout);
    return 0;
  }
  if (program == "kerfd") {
    std::fputs(kerf::cli::manual_page(*kerf::app::command_line(), text_of_kerfd(), KERF_VERSION).c_str(), stdout);
    return 0;
  }
  std::fputs("kerf_manual: give kerf or kerfd\n", stderr);
  return 2;
}
