#!/bin/sh
# Rebuilds the JavaScript libraries inside the report: three.js with orbit control, and uPlot, as one file.
# Needs node and npm, set up to reach their registry. Run it from anywhere; it writes into the source tree.
set -eu
three=0.187.0 uplot=1.6.32 esbuild=0.28.2
assets=$(cd "$(dirname "$0")/.." && pwd)/src/holonom/app/report/assets
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --no-audit --no-fund --ignore-scripts "three@$three" "uplot@$uplot" "esbuild@$esbuild" >/dev/null

cat >entry.js <<'JS'
export {
  BufferGeometry, CanvasTexture, CapsuleGeometry, CylinderGeometry, DirectionalLight, Float32BufferAttribute,
  GridHelper, Group, HemisphereLight, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, MeshStandardMaterial,
  PCFShadowMap, PerspectiveCamera, PlaneGeometry, Quaternion, Scene, ShadowMaterial, SRGBColorSpace, Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";
export { default as uPlot } from "uplot";
JS
node_modules/.bin/esbuild entry.js --bundle --minify --format=iife --global-name=vendor --target=es2020 \
  --legal-comments=none --charset=utf8 --outfile="$assets/vendor.min.js" --log-level=warning
cp node_modules/uplot/dist/uPlot.min.css "$assets/uplot.min.css"
cp node_modules/three/LICENSE "$assets/LICENSE.three"
cp node_modules/uplot/LICENSE "$assets/LICENSE.uplot"
printf 'three %s, uPlot %s, bundled with esbuild %s\n' "$three" "$uplot" "$esbuild" >"$assets/VERSIONS"
ls -l "$assets"
