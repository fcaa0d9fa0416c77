#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes echarts.min.js from the packages that package.json pins: `npm install && npm run build` in this folder.
# The licences travel inside the bundle, because every report is a copy of it.
set -eu
cd "$(dirname "$0")"
{
  echo "/*! Apache ECharts 6.1.0 (Apache-2.0, https://www.apache.org/licenses/LICENSE-2.0), with zrender 6.1.0, parts of d3 and tslib."
  for notice in NOTICE-echarts LICENSE-zrender LICENSE-d3 LICENSE-tslib; do
    echo "--- $notice"
    cat "$notice"
  done
  echo "*/"
} >banner.tmp
node_modules/.bin/esbuild echarts.entry.js --bundle --minify --format=iife --global-name=echarts --target=es2019 \
  --charset=ascii --legal-comments=none --outfile=bundle.tmp
cat banner.tmp bundle.tmp >echarts.min.js
rm banner.tmp bundle.tmp
