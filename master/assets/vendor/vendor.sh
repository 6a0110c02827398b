#!/usr/bin/env bash
# Makes the vendored files anew from the packages of npm, in the versions that README.md names. Needs node and npm.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --save-exact three@0.187.0 uplot@1.6.32 esbuild@0.28.2

cp "$here/three.entry.js" .
echo '/*! three.js 0.187.0, https://threejs.org, Copyright 2010-2026 three.js authors, MIT licence */' >three.min.js
npx esbuild three.entry.js --bundle --minify --format=iife --global-name=THREE --target=es2022 >>three.min.js
cp three.min.js "$here/"
cp node_modules/three/LICENSE "$here/three.LICENSE"
cp node_modules/uplot/dist/uPlot.iife.min.js "$here/uPlot.min.js"
cp node_modules/uplot/dist/uPlot.min.css "$here/"
cp node_modules/uplot/LICENSE "$here/uPlot.LICENSE"
