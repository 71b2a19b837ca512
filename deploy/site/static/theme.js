// Chooses light or dark before the page is drawn. The theme has this line within its pages, where kerfd runs no script.
document.body.dataset.theme = localStorage.getItem('theme') || 'auto';
