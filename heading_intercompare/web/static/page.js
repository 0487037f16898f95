/* What only the browser knows: its palette, the operator's name, whether the page is live, sound, and the zoom. */
(() => {
  const root = document.documentElement;
  const PALETTES = ['day', 'dusk', 'night'];
  const SILENCE_MS = 30000, DEAD_S = 2;
  const BEEPS = {alarm: [3, 4000], warning: [2, 8000]};

  const remember = (key, value) => {
    try { localStorage.setItem(key, value); } catch (error) { return; }
  };
  const recall = key => { try { return localStorage.getItem(key); } catch (error) { return null; } };
  const press = name => PALETTES.forEach(palette => document.querySelectorAll(`.k-${palette}`)
    .forEach(button => button.setAttribute('aria-pressed', String(palette === name))));

  root.lang = 'en';
  root.dataset.palette = PALETTES.includes(recall('palette')) ? recall('palette') : 'day';
  window.choosePalette = name => {
    root.dataset.palette = name;
    press(name);
    remember('palette', name);
  };

  // Heard from the first letter: the field may be filled before the page asks for the name it kept.
  document.addEventListener('input', event => {
    if (event.target.closest('.k-name')) remember('operator', event.target.value);
  });
  const recallName = field => {
    if (field.value) return;
    field.value = recall('operator') || '';
    field.dispatchEvent(new Event('input', {bubbles: true}));
  };

  let audio = null, silentUntil = 0, lastSound = 0;
  const beep = count => {
    audio = audio || new (window.AudioContext || window.webkitAudioContext)();
    audio.resume();
    for (let at = 0; at < count; at += 1) {
      const tone = audio.createOscillator(), loudness = audio.createGain();
      tone.frequency.value = 880;
      loudness.gain.value = 0.2;
      tone.connect(loudness).connect(audio.destination);
      tone.start(audio.currentTime + 0.3 * at);
      tone.stop(audio.currentTime + 0.3 * at + 0.18);
    }
  };
  window.testSound = () => { silentUntil = 0; beep(2); };
  window.silence = () => { silentUntil = performance.now() + SILENCE_MS; };

  let beat = '', at = performance.now(), clock = '';
  const look = () => {
    const mark = document.querySelector('.k-beat');
    const dead = document.getElementById('page-dead');
    if (!mark || !dead) return;
    if (mark.textContent !== beat) {
      beat = mark.textContent;
      at = performance.now();
      clock = new Date().toISOString().slice(11, 19);
    }
    const now = performance.now(), seconds = (now - at) / 1000;
    const state = seconds > DEAD_S ? 'yes' : 'no';
    if (root.dataset.dead !== state) {
      root.dataset.dead = state;
      dead.textContent = state === 'yes' ? `✖ NOT LIVE, last ${clock} UTC` : '';
    }
    const alert = document.querySelector('.alert');
    const [count, period] = BEEPS[alert && alert.dataset.sound] || [0, 0];
    if (count && audio && now > silentUntil && now - lastSound > period) {
      lastSound = now;
      beep(count);
    }
    const left = Math.ceil((silentUntil - now) / 1000);
    const button = document.querySelector('.k-silence .block');
    const words = left > 0 ? `Silent ${left} s` : 'Silence';
    if (button && button.textContent !== words) button.textContent = words;
  };
  setInterval(look, 200);
  document.addEventListener('pointerdown', () => {
    audio = audio || new (window.AudioContext || window.webkitAudioContext)();
  }, {once: true});
  document.addEventListener('DOMContentLoaded', () => {
    const waiting = setInterval(() => {
      if (!document.querySelector('.k-day')) return;
      press(root.dataset.palette);
      recallName(document.querySelector('.k-name input'));
      clearInterval(waiting);
    }, 100);
  });

  let drag = null;
  const share = event => {
    const box = drag.picture.getBoundingClientRect();
    return Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
  };
  document.addEventListener('pointerdown', event => {
    const picture = event.target.closest && event.target.closest('.picture');
    if (!picture) return;
    drag = {picture};
    drag.from = share(event);
    drag.mark = document.createElement('i');
    drag.mark.className = 'chosen';
  });
  document.addEventListener('pointermove', event => {
    if (!drag) return;
    const to = share(event);
    if (!drag.mark.isConnected) drag.picture.append(drag.mark);
    drag.mark.style.left = `${100 * Math.min(drag.from, to)}%`;
    drag.mark.style.width = `${100 * Math.abs(to - drag.from)}%`;
  });
  document.addEventListener('pointerup', event => {
    if (!drag) return;
    const to = share(event), low = Math.min(drag.from, to), high = Math.max(drag.from, to);
    drag.mark.remove();
    drag = null;
    if (high - low > 0.02) emitEvent('zoom', [low, high]);
  });
})();
