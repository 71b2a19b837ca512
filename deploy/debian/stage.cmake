# Adds to the folder of which CPack makes the package: the service, its configuration, licences and changelogs, and what
# Debian wants compressed or elsewhere. CPack runs it after `cmake --install`.
cmake_minimum_required(VERSION 3.25)
set(stage ${CPACK_TEMPORARY_DIRECTORY})
set(source ${CPACK_KERF_SOURCE})
set(doc ${stage}/usr/share/doc/kerf)
set(destdir $ENV{DESTDIR})  # CPack has set it; here all paths are whole.
set(ENV{DESTDIR})

# Compresses a file in place, the same bytes each time.
function(compress file)
  execute_process(COMMAND gzip -9nf ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(INSTALL ${source}/deploy/systemd/kerfd.service DESTINATION ${stage}/lib/systemd/system)
file(INSTALL ${source}/deploy/debian/kerfd.conf DESTINATION ${stage}/etc/kerf)
file(INSTALL ${source}/deploy/debian/copyright ${source}/deploy/debian/README.Debian DESTINATION ${doc})
file(INSTALL ${source}/deploy/examples DESTINATION ${doc})
file(INSTALL ${source}/deploy/systemd/gpu.conf ${source}/deploy/haproxy.cfg ${source}/deploy/grafana ${source}/deploy/scenes
     DESTINATION ${doc}/examples)

# The package is made from this repository, so there is no bug of Debian that its first version closes.
file(WRITE ${stage}/usr/share/lintian/overrides/kerf "kerf: initial-upload-closes-no-bugs *\n")

# Texts of the licences of what is compiled into the programs and the viewer; shared libraries bring their own.
foreach(package IN ITEMS libboost-dev libcli11-dev libeigen3-dev libhwy-dev libprotobuf-dev libspectra-dev nlohmann-json3-dev)
  file(INSTALL /usr/share/doc/${package}/copyright DESTINATION ${doc}/third-party RENAME ${package})
endforeach()
if(EXISTS ${stage}/usr/share/kerf/web)
  file(INSTALL ${source}/web/node_modules/three/LICENSE DESTINATION ${doc}/third-party RENAME three)
endif()

file(INSTALL ${source}/CHANGELOG.md DESTINATION ${doc} RENAME changelog)
compress(${doc}/changelog)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${doc}/changelog.Debian
  "kerf (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) stable; urgency=medium\n\n"
  "  * See changelog.gz.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
compress(${doc}/changelog.Debian)
foreach(page IN ITEMS kerf kerfd)
  compress(${stage}/usr/share/man/man1/${page}.1)
endforeach()
# Debian's zsh looks here.
file(INSTALL ${stage}/usr/share/zsh/site-functions/_kerf DESTINATION ${stage}/usr/share/zsh/vendor-completions)
file(REMOVE_RECURSE ${stage}/usr/share/zsh/site-functions)
set(ENV{DESTDIR} ${destdir})
