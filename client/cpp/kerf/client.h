#pragma once

// The client library: a Kerf server and its sheets as typed calls over gRPC, and live frames of a sheet.
//
//   kerf::client::Server server("127.0.0.1:50051");
//   auto sheet = server.create(kerf::client::grid_scene(60, 40, 1.5, 1.0));
//   sheet->cut(kerf::client::circle({0.5, 0.5}, 0.2));
//
// Link kerf::client of find_package(kerf COMPONENTS client). client/cpp/README.md has a longer example.
#include "client/cpp/client.h"      // generated stubs of every service, for what has no method
#include "client/cpp/run_writer.h"  // frames into an .npz file
#include "client/cpp/scene.h"       // what sheets are made from
#include "client/cpp/server.h"      // Server, which makes and lists sheets
#include "client/cpp/sheet.h"       // Sheet: cuts, time, interaction, output
