#!/bin/sh
# Copies the published files of uPlot VERSION here: renew.sh 1.6.32. Needs npm; building and testing geardyn do not.
set -eu
cd "$(dirname "$0")"
folder=$(mktemp -d)
(cd "$folder" && npm pack --silent "uplot@$1" && tar xzf "uplot-$1.tgz")
cp "$folder/package/dist/uPlot.iife.min.js" "$folder/package/dist/uPlot.min.css" "$folder/package/LICENSE" .
sha256sum uPlot.iife.min.js
